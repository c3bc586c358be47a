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
  for (int slot = effect_first; slot < slot_count; ++slot) b.sys.p[slot].set(i, m.sys.p[slot]);
  for (int which = 0; which < table_count; ++which) {
    const int knots = m.sys.structure.table[which].knots;
    for (int k = 0; k <= knots && knots > 0; ++k)
      for (int j = 0; j < 4; ++j) b.sys.table[which][k][j].set(i, m.sys.table[which][k][j]);
  }
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
  side_of(b, i, b.member[i]->on);
  give_back(b, i, state_count);
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
