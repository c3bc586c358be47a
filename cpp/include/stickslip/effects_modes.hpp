// Mode changes of a piece with effects.
#pragma once

#include "stickslip/effects_watch.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Signs and flags at the first instant of a slip (or of a stick).
template <class T>
void leave_rest(const System<T>& sys, State<T>& s, Mode& mode, Side* on) {
  s.z[hidden_dwell] = mode.contact == 0 ? s.z[hidden_dwell] : T(0.0);
  if (mode.contact == 0) return;
  on[watch_contact] = Side::lower;
  if (has(sys, fx_quadratic) && value(s.z[1]) == 0) {  // off a belt at rest: x2 has the sign of v_w
    mode.x2_sign = mode.contact;
    on[watch_x2] = Side::lower;
  }
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

inline constexpr int first_moves = 4;  // derivatives of v that say where a block on bristles goes

// The contact mode of a block at rest on the belt, from its margins (or, on bristles, from where v goes).
template <class T>
void settle_at_rest(const System<T>& sys, State<T>& s, Mode& mode, Side* on, Piece<T>& piece) {
  const bool memory_runs_on = mode.contact != 0;
  const int before = mode.contact;
  mode.saturated = false;
  for (int i = 0; i < 4; ++i) state_series(piece, i)[0] = s.z[i];
  if (has(sys, fx_compliance)) {
    mode.contact = 1;
    expand_effects(sys, mode, s, first_moves, piece);
    int k = 1;  // riding the belt with its spring relaxed, it leaves by a higher derivative than the first
    while (k < first_moves && value(piece.fx.v[k]) == 0) ++k;
    mode.contact = value(piece.fx.v[k]) < 0 ? -1 : 1;
  } else {
    mode.contact = 0;
    if (before != 0) s.z[hidden_dwell] = T(0.0);  // it has just come to rest; a run may begin in a rest that has lasted
    expand_effects(sys, mode, s, 0, piece);
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
