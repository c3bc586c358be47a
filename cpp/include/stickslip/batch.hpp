// W trajectories in the same mode, stepped together. A lane that meets a surface or its time leaves; another enters.
#pragma once

#include "stickslip/long_stretch.hpp"
#include "stickslip/member.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <int W>
struct Batch {
  using L = Lanes<W>;
  System<L> sys;
  State<L> s;
  Mode mode;
  Piece<L> piece;
  L limit;
  L stick, steps;
  typename L::Bits on_lower, on_upper;  // lanes that stand on a bound of the watch and are leaving it
  Member* member[W] = {};
  unsigned busy = 0;
  int active = 0;
  long turns = 0;                            // steps of the batch
  bool one_law = false;                      // all members have the same: a lane that holds it need not copy it again
  unsigned holds_minus = 0, holds_plus = 0;  // lanes that hold this branch of it

  const typename L::Bits& standing(Side side) const { return side == Side::lower ? on_lower : on_upper; }
};

template <int W>
void copy_branch(Branch<Lanes<W>>& to, int i, const Branch<double>& from) {
  to.curve = from.curve;
  to.has_kink = from.has_kink;
  to.static_limit.set(i, from.static_limit);
  to.c0.set(i, from.c0);
  to.c1.set(i, from.c1);
  for (int k = 0; k < curve_numbers; ++k) to.own[k].set(i, from.own[k]);
  to.saturated.set(i, from.saturated);
  to.kink.set(i, from.has_kink ? from.kink : 0.0);
}

template <int W>
void copy_rig(Rig<Lanes<W>>& to, int i, const Rig<double>& from) {
  to.two = from.two;
  const double values[] = {from.a1, from.over_a1, from.kx, from.e1, from.s, from.over_a2, from.b3, from.e12, from.v_b};
  Lanes<W>* slots[] = {&to.a1, &to.over_a1, &to.kx, &to.e1, &to.s, &to.over_a2, &to.b3, &to.e12, &to.v_b};
  for (int k = 0; k < 9; ++k) slots[k]->set(i, values[k]);
}

template <int W>
void enter(Batch<W>& b, int i, Member* m) {
  copy_rig(b.sys.rig, i, m->sys.rig);
  const auto hold = [&](unsigned& held, Branch<Lanes<W>>& to, const Branch<double>& from) {
    if (b.one_law && (held >> i & 1u) != 0) return;
    copy_branch(to, i, from);
    held |= 1u << i;
  };
  if (m->mode.contact <= 0) hold(b.holds_minus, b.sys.minus, m->sys.minus);
  if (m->mode.contact >= 0) hold(b.holds_plus, b.sys.plus, m->sys.plus);
  b.sys.structure.effects = 0;
  b.sys.stick_step.set(i, m->sys.stick_step);
  b.sys.floor_step.set(i, m->sys.floor_step);
  b.sys.line_step.set(i, m->sys.line_step);
  b.sys.frequency.set(i, m->sys.frequency);
  for (int k = 0; k < 4; ++k) b.s.z[k].set(i, m->s.z[k]);
  b.s.t.set(i, m->s.t);
  b.limit.set(i, m->limit);
  b.on_lower[i] = m->on[watch_contact] == Side::lower ? -1 : 0;
  b.on_upper[i] = m->on[watch_contact] == Side::upper ? -1 : 0;
  b.stick.set(i, 0.0);
  b.steps.set(i, m->tally.row.steps);
  b.mode = m->mode;
  b.member[i] = m;
  b.busy |= 1u << i;
  ++b.active;
}

// Lane i gives its member back as it is now, with its first `states` states.
template <class AnyBatch>
void give_back(AnyBatch& b, int i, int states) {
  Member* m = b.member[i];
  for (int k = 0; k < states; ++k) m->s.z[k] = b.s.z[k][i];
  m->s.t = b.s.t[i];
  m->tally.row.stick_time += b.stick[i];
  m->tally.row.steps = b.steps[i];
  b.member[i] = nullptr;
  b.busy &= ~(1u << i);
  --b.active;
}
template <int W>
void leave(Batch<W>& b, int i) {
  give_back(b, i, 4);
}

// An idle lane copies a busy one, so that it computes something harmless.
template <int W>
void fill_idle(Batch<W>& b, int busy) {
  Member* m = b.member[busy];
  for (int i = 0; i < W; ++i) {
    if (b.member[i] != nullptr) continue;
    enter(b, i, m);
    --b.active;
    b.busy &= ~(1u << i);
    b.member[i] = nullptr;
    for (int k = 0; k < 4; ++k) b.s.z[k].set(i, b.s.z[k][busy]);
    b.s.t.set(i, b.s.t[busy]);
    b.on_lower[i] = b.on_lower[busy];
    b.on_upper[i] = b.on_upper[busy];
  }
}

// What the sweep observes of this step.
template <int W>
void observe(const SweepRequest& q, Batch<W>& b, int p, const Lanes<W>& h) {
  for (int i = 0; i < W; ++i) {
    Member* m = b.member[i];
    if (m == nullptr || m->limit < q.t_end) continue;
    Strided z[4];
    for (int k = 0; k < 4; ++k) z[k] = {reinterpret_cast<const double*>(state_series(b.piece, k)) + i, W};
    observe_step(m->tally, q.observe, m->sys.rig, z, b.mode.contact, p, h[i]);
  }
}

// Crosses what is left of a linear mode, of lanes that have been in it for long; h are their ordinary steps.
template <int W>
void cross_long(const SweepRequest& q, Batch<W>& b, const Lanes<W>& h) {
  if (b.mode.contact != 0 && (q.observe & (ob_range | ob_dissipated)) != 0) return;
  const Watch<Lanes<W>>& watch = b.piece.watch[0];
  for (int i = 0; i < W; ++i) {
    Member* m = b.member[i];
    if (m == nullptr || b.steps[i] - m->tally.row.steps < static_cast<double>(patience)) continue;
    for (int k = 0; k < 4; ++k) m->s.z[k] = b.s.z[k][i];
    m->s.t = b.s.t[i];
    Watch<double> one{nullptr, watch.lo[i], watch.hi[i], 0.0, watch.has_lo, watch.has_hi, watch.id};
    const double far = cross(m->sys, b.mode, one, h[i], m->limit - m->s.t, m->s);
    if (!(far > 0)) continue;
    for (int k = 0; k < 4; ++k) b.s.z[k].set(i, m->s.z[k]);
    b.s.t.set(i, m->s.t);
    b.steps.set(i, b.steps[i] + 1);
    if (b.mode.contact == 0) b.stick.set(i, b.stick[i] + far);
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
