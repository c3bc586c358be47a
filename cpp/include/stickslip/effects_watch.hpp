// Switching functions of a piece with effects.
#pragma once

#include "stickslip/effects_piece.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Append a watch on `sign` times a series (plus a constant); returns it for its bounds.
template <class T>
Watch<T>& watch_series(Piece<T>& piece, WatchId id, const T* c, double sign, int order) {
  T* out = piece.switching[piece.watches];
  for (int k = 0; k <= order; ++k) out[k] = c[k] * sign;
  Watch<T>& w = piece.watch[piece.watches++];
  w.id = id;
  w.has_lo = w.has_hi = false;
  w.rounding = Real<T>(0.0);
  w.c = out;
  return w;
}
template <class T>
void above(Watch<T>& w, const T& bound) {
  w.has_lo = true;
  w.lo = bound;
}
template <class T>
void below(Watch<T>& w, const T& bound) {
  w.has_hi = true;
  w.hi = bound;
}

template <class T>
void watch_contact_effects(const System<T>& sys, const Mode& mode, int order, Piece<T>& piece) {
  EffectSeries<T>& fx = piece.fx;
  if (mode.contact == 0) {  // margins to the static limits, q = -friction
    Watch<T>& upper = watch_series(piece, watch_contact, fx.limit_minus, 1.0, order);
    Watch<T>& lower = watch_series(piece, watch_demand, fx.limit_plus, 1.0, order);
    T *up = piece.switching[piece.watches - 2], *down = piece.switching[piece.watches - 1];
    for (int k = 0; k <= order; ++k) {
      up[k] = up[k] + fx.friction[k];
      down[k] = down[k] - fx.friction[k];
    }
    above(upper, T(0.0));
    above(lower, T(0.0));
    upper.rounding = lower.rounding = value(up[0] + down[0]) * limit_rounding;
    return;
  }
  above(watch_series(piece, watch_contact, fx.v, mode.contact, order), T(0.0));
  const Branch<T>& b = branch_in(sys, mode);
  if (b.has_kink) {
    Watch<T>& w = watch_series(piece, watch_kink, fx.u, 1.0, order);
    mode.saturated ? above(w, b.kink) : below(w, b.kink);
  }
  if (has(sys, fx_memory)) above(watch_series(piece, watch_memory, fx.u, 1.0, order), T(0.0));
}

// A speed this small beside the motion's is rounding: surfaces of x2 and y2 may coincide at 0.
constexpr double speed_rounding = 1e-15;

template <class T>
void watch_effects(const System<T>& sys, const Mode& mode, int order, Piece<T>& piece) {
  const Parameters<T>& p = sys.p;
  EffectSeries<T>& fx = piece.fx;
  const bool speeds = has(sys, fx_quadratic) || has(sys, fx_pivot) || has(sys, fx_table);
  const Real<T> rounding = speeds ? Real<T>(motion_scale(sys, piece.s) * speed_rounding) : Real<T>(0.0);
  piece.watches = 0;
  watch_contact_effects(sys, mode, order, piece);
  if (has(sys, fx_quadratic)) {
    Watch<T>& w = watch_series(piece, watch_x2, piece.s.x2, mode.x2_sign, order);
    above(w, T(0.0));
    w.rounding = rounding;
  }
  if (has(sys, fx_gap)) {
    Watch<T>& w = watch_series(piece, watch_gap, piece.s.y1, 1.0, order);
    const T d = p[spring_gap_k3_d];
    if (mode.gap >= 0) above(w, mode.gap > 0 ? d : -d);
    if (mode.gap <= 0) below(w, mode.gap < 0 ? -d : d);
  }
  if (has(sys, fx_pivot) && creeps(sys)) {
    const T reach = p[pivot_dry_friction_v_c] * creep_reach;
    Watch<T>& w = watch_series(piece, watch_pivot, piece.s.y2, 1.0, order);
    if (mode.pivot >= 0) above(w, mode.pivot > 0 ? reach : -reach);
    if (mode.pivot <= 0) below(w, mode.pivot < 0 ? -reach : reach);
  } else if (has(sys, fx_pivot)) {
    if (mode.pivot != 0) {
      Watch<T>& w = watch_series(piece, watch_pivot, piece.s.y2, mode.pivot, order);
      above(w, T(0.0));
      w.rounding = rounding;
    } else {
      Watch<T>& w = watch_series(piece, watch_pivot, fx.pivot_force, 1.0, order);
      above(w, -p[pivot_dry_friction_f]);
      below(w, p[pivot_dry_friction_f]);
    }
  }
  if (has(sys, fx_normal)) {
    Watch<T>& w = watch_series(piece, watch_lift, fx.normal, 1.0, order);
    mode.lifted ? below(w, T(0.0)) : above(w, T(0.0));
  }
  if (has(sys, fx_table)) {
    Watch<T>& w = watch_series(piece, watch_table, fx.variable, 1.0, order);
    const TableVariable of = sys.structure.table_variable;
    if (of == TableVariable::x2 || of == TableVariable::y2) w.rounding = rounding;
    if (mode.knot > 0) above(w, T(sys.structure.knot[mode.knot - 1]));
    if (mode.knot < sys.structure.knots) below(w, T(sys.structure.knot[mode.knot]));
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
