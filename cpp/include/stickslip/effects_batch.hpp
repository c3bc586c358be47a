// W trajectories of a model with effects, all in one mode, stepped together.
#pragma once

#include "stickslip/batch.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <int W>
struct EffectBatch {
  using L = Lanes<W>;
  using Bits = typename L::Bits;
  System<L> sys;
  State<L> s;
  Mode mode;
  Piece<L> piece;
  L limit, stick, steps;
  Bits on_lower[watch_count], on_upper[watch_count];  // lanes that stand on a bound of a watch and are leaving it
  Member* member[W] = {};
  unsigned busy = 0;
  int active = 0;

  Bits& standing(int id, Side side) { return side == Side::lower ? on_lower[id] : on_upper[id]; }
};

template <int W>
void set_side(EffectBatch<W>& b, int i, const Side* on) {
  for (int id = 0; id < watch_count; ++id) {
    b.on_lower[id][i] = on[id] == Side::lower ? -1 : 0;
    b.on_upper[id][i] = on[id] == Side::upper ? -1 : 0;
  }
}
template <int W>
void side_of(const EffectBatch<W>& b, int i, Side* on) {
  for (int id = 0; id < watch_count; ++id)
    on[id] = b.on_lower[id][i] != 0 ? Side::lower : b.on_upper[id][i] != 0 ? Side::upper : Side::none;
}

// Lane i takes a member's numbers; the first to come brings the structure too.
template <int W>
void put(EffectBatch<W>& b, int i, const Member& m) {
  copy_rig(b.sys.rig, i, m.sys.rig);
  copy_branch(b.sys.minus, i, m.sys.minus);
  copy_branch(b.sys.plus, i, m.sys.plus);
  for (int slot = block_viscous_damping_c; slot < slot_count; ++slot) b.sys.p[slot].set(i, m.sys.p[slot]);
  const int intervals = has(m.sys, fx_table) ? m.sys.structure.knots + 1 : 0;
  for (int k = 0; k < intervals; ++k)
    for (int j = 0; j < 4; ++j) b.sys.table[k][j].set(i, m.sys.table[k][j]);
  b.sys.frequency.set(i, m.sys.frequency);
  for (int k = 0; k < state_count; ++k) b.s.z[k].set(i, m.s.z[k]);
  b.s.t.set(i, m.s.t);
  b.limit.set(i, m.limit);
  b.stick.set(i, 0.0);
  b.steps.set(i, m.tally.row.steps);
  set_side(b, i, m.on);
}

template <int W>
void enter(EffectBatch<W>& b, int i, Member* m) {
  if (b.active == 0) {
    b.sys.structure = m->sys.structure;
    b.mode = m->mode;
  }
  put(b, i, *m);
  b.member[i] = m;
  b.busy |= 1u << i;
  ++b.active;
}

template <int W>
void leave(EffectBatch<W>& b, int i) {
  Member* m = b.member[i];
  for (int k = 0; k < state_count; ++k) m->s.z[k] = b.s.z[k][i];
  m->s.t = b.s.t[i];
  m->tally.row.stick_time += b.stick[i];
  m->tally.row.steps = b.steps[i];
  side_of(b, i, m->on);
  b.member[i] = nullptr;
  b.busy &= ~(1u << i);
  --b.active;
}

// Idle lanes copy a busy one, as it is now, so that they compute something harmless.
template <int W>
void fill_idle(EffectBatch<W>& b) {
  const int busy = __builtin_ctz(b.busy);
  for (int i = 0; i < W; ++i) {
    if (b.member[i] != nullptr) continue;
    put(b, i, *b.member[busy]);
    for (int k = 0; k < state_count; ++k) b.s.z[k].set(i, b.s.z[k][busy]);
    b.s.t.set(i, b.s.t[busy]);
  }
}

// The first exit of lane i within h, as the scalar kernel finds it.
template <int W>
Exit<double> exit_of(EffectBatch<W>& b, int i, int order, double h) {
  Watch<double> watches[watch_count];
  double c[watch_count][series_size];
  for (int w = 0; w < b.piece.watches; ++w) {
    const Watch<Lanes<W>>& from = b.piece.watch[w];
    for (int k = 0; k <= order; ++k) c[w][k] = from.c[k][i];
    watches[w] = {c[w],
                  from.has_lo ? from.lo[i] : 0.0,
                  from.has_hi ? from.hi[i] : 0.0,
                  from.rounding[i],
                  from.has_lo,
                  from.has_hi,
                  from.id};
  }
  Side on[watch_count];
  side_of(b, i, on);
  return first_exit(watches, b.piece.watches, order, h, on, true);
}

// Steps of the lanes that meet a surface are cut short there; `exits` says where. Returns those lanes.
template <int W>
unsigned land(EffectBatch<W>& b, int order, Lanes<W>& h, Exit<double>* exits) {
  unsigned suspected = 0, events = 0;
  for (int w = 0; w < b.piece.watches; ++w) {
    const Watch<Lanes<W>>& watch = b.piece.watch[w];
    const Lanes<W> rest = tail(watch.c, order, h);
    for (const Side side : {Side::lower, Side::upper})
      if (side == Side::lower ? watch.has_lo : watch.has_hi)
        suspected |= suspects<W>(watch, side, b.standing(watch.id, side), h, rest);
  }
  for (unsigned left = suspected & b.busy; left != 0; left &= left - 1) {
    const int i = __builtin_ctz(left);
    exits[i] = exit_of(b, i, order, h[i]);
    if (!exits[i].found) continue;
    h.set(i, exits[i].t);
    events |= 1u << i;
  }
  return events;
}

// A step on, a lane stands on no surface any more, unless it has not moved away from it.
template <int W>
void leave_surfaces(EffectBatch<W>& b, int order, const Lanes<W>& h) {
  typename Lanes<W>::Bits lower[watch_count] = {}, upper[watch_count] = {};
  for (int w = 0; w < b.piece.watches && b.mode.contact == 0; ++w) {
    const Watch<Lanes<W>>& watch = b.piece.watch[w];
    if (mask_of<W>(watch.rounding.v > 0) == 0 || mask_of<W>(b.on_lower[watch.id]) == 0) continue;
    const Lanes<W> margin = evaluate(watch.c, order, h) - watch.lo;
    lower[watch.id] = b.on_lower[watch.id] & (abs(margin).v <= watch.rounding.v);
  }
  for (int id = 0; id < watch_count; ++id) {
    b.on_lower[id] = lower[id];
    b.on_upper[id] = upper[id];
  }
}

// What the sweep observes of this step.
template <int W>
void observe(const SweepRequest& q, EffectBatch<W>& b, int order, const Lanes<W>& h) {
  const auto series = [](const Lanes<W>* c, int i) { return Strided{reinterpret_cast<const double*>(c) + i, W}; };
  for (unsigned left = b.busy; left != 0; left &= left - 1) {
    const int i = __builtin_ctz(left);
    Member* m = b.member[i];
    if (m->limit < q.t_end) continue;
    Strided z[4];
    for (int k = 0; k < 4; ++k) z[k] = series(state_series(b.piece, k), i);
    observe_step(m->tally, q.observe & ~ob_dissipated, m->sys.rig, z, b.mode.contact, order, h[i]);
    if ((q.observe & ob_dissipated) != 0 && b.mode.contact != 0)
      m->tally.row.dissipated += work(series(b.piece.fx.friction, i), series(b.piece.fx.v, i), order - 1, h[i]);
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
