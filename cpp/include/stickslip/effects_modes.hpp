// Switching functions and mode changes of a piece with effects.
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

template <class T>
void watch_effects(const System<T>& sys, const Mode& mode, int order, Piece<T>& piece) {
  const Parameters<T>& p = sys.p;
  EffectSeries<T>& fx = piece.fx;
  piece.watches = 0;
  watch_contact_effects(sys, mode, order, piece);
  if (has(sys, fx_quadratic)) above(watch_series(piece, watch_x2, piece.s.x2, mode.x2_sign, order), T(0.0));
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
      above(watch_series(piece, watch_pivot, piece.s.y2, mode.pivot, order), T(0.0));
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
    if (mode.knot > 0) above(w, T(sys.structure.knot[mode.knot - 1]));
    if (mode.knot < sys.structure.knots) below(w, T(sys.structure.knot[mode.knot]));
  }
}

// Signs and flags at the first instant of a slip (or of a stick).
template <class T>
void leave_rest(const System<T>& sys, State<T>& s, Mode& mode, Side* on) {
  s.z[hidden_dwell] = mode.contact == 0 ? s.z[hidden_dwell] : T(0.0);
  if (mode.contact == 0) return;
  on[watch_contact] = Side::lower;
  if (!has(sys, fx_memory)) return;
  const double w = static_cast<double>(value(s.z[hidden_w]));
  if (w == 0) {
    mode.w_sign = mode.contact;
    on[watch_memory] = Side::lower;
  } else {
    mode.w_sign = w < 0 ? -1 : 1;
    const Branch<T>& b = branch_in(sys, mode);
    mode.saturated = b.has_kink && std::abs(w) >= static_cast<double>(value(b.kink));
  }
}

// The contact mode of a block at rest on the belt, from its margins (or, on bristles, from where v goes).
template <class T>
void settle_at_rest(const System<T>& sys, State<T>& s, Mode& mode, Side* on, Piece<T>& piece) {
  const bool memory_runs_on = mode.contact != 0;
  const int before = mode.contact;
  mode.saturated = false;
  for (int i = 0; i < 4; ++i) state_series(piece, i)[0] = s.z[i];
  if (has(sys, fx_compliance)) {
    mode.contact = 1;
    expand_effects(sys, mode, s, 1, piece);
    mode.contact = value(piece.fx.v[1]) < 0 ? -1 : 1;
  } else {
    mode.contact = 0;
    const T dwell = s.z[hidden_dwell];
    s.z[hidden_dwell] = T(0.0);
    expand_effects(sys, mode, s, 0, piece);
    s.z[hidden_dwell] = before == 0 ? dwell : T(0.0);
    s.z[1] = piece.s.x2[0];
    const auto real = [](const T& x) { return static_cast<double>(value(x)); };
    Side stands = Side::none;
    mode.contact = contact_at_rest(real(piece.fx.limit_minus[0] + piece.fx.friction[0]),
                                   real(piece.fx.limit_plus[0] - piece.fx.friction[0]),
                                   real(piece.fx.limit_minus[0] + piece.fx.limit_plus[0]), stands);
    if (stands == Side::upper) on[watch_contact] = Side::lower;  // the margins are watched from below
    if (stands == Side::lower) on[watch_demand] = Side::lower;
  }
  if (!(memory_runs_on && mode.contact == -before)) s.z[hidden_w] = T(0.0);
  leave_rest(sys, s, mode, on);
}

template <class T>
void change_pivot(const System<T>& sys, State<T>& s, Mode& mode, Side* on, Side side, Piece<T>& piece) {
  if (mode.pivot == 0) {
    mode.pivot = side == Side::upper ? 1 : -1;
  } else {
    s.z[3] = T(0.0);
    for (int i = 0; i < 4; ++i) state_series(piece, i)[0] = s.z[i];
    mode.pivot = 0;
    expand_effects(sys, mode, s, 0, piece);
    const double g = static_cast<double>(value(piece.fx.pivot_force[0]));
    const double f = static_cast<double>(value(sys.p[pivot_dry_friction_f]));
    if (g > f) mode.pivot = 1;
    if (g < -f) mode.pivot = -1;
  }
  if (mode.pivot != 0) on[watch_pivot] = Side::lower;
}

template <class T>
void change_effects(const System<T>& sys, State<T>& s, Mode& mode, Side* on, int id, Side side, Piece<T>& piece) {
  const int step = side == Side::lower ? -1 : 1;
  switch (id) {
    case watch_contact:
    case watch_demand:
      if (mode.contact != 0) return settle_at_rest(sys, s, mode, on, piece);
      mode.contact = id == watch_contact ? -1 : 1;
      mode.saturated = false;
      s.z[hidden_w] = T(0.0);
      return leave_rest(sys, s, mode, on);
    case watch_kink: mode.saturated = !mode.saturated; break;
    case watch_x2: mode.x2_sign = -mode.x2_sign; return void(on[id] = side);
    case watch_memory: mode.w_sign = -mode.w_sign; return void(on[id] = side);
    case watch_gap: mode.gap += step; break;
    case watch_lift: mode.lifted = !mode.lifted; break;
    case watch_pivot:
      if (!creeps(sys)) return change_pivot(sys, s, mode, on, side, piece);
      mode.pivot += step;
      break;
    default:
      mode.knot += step;
      if (sys.structure.table_variable == TableVariable::t && sys.structure.table_period > 0 &&
          mode.knot == sys.structure.knots) {
        mode.knot = 1;
        ++mode.cycle;
      }
  }
  on[id] = opposite(side);
}

}  // namespace stickslip::inline STICKSLIP_ISA
