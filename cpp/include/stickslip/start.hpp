// Which series, which surfaces, which mode: plain or with effects, the same calls for the mode machine.
#pragma once

#include "stickslip/step.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Expand the piece that starts at `state` and list its switching functions. Returns the order of the series;
// `linear_step` is the step of a linear piece, 0 where the tolerance decides.
template <class T>
int expand(const System<T>& sys, const Mode& mode, const State<T>& state, int curve_order, Piece<T>& piece,
           Real<T>& linear_step) {
  Series<T>& s = piece.s;
  s.x1[0] = state.z[0];
  s.x2[0] = state.z[1];
  s.y1[0] = state.z[2];
  s.y2[0] = state.z[3];
  if (sys.structure.effects == 0) return expand_plain(sys, mode, curve_order, piece, linear_step);
  linear_step = Real<T>(0.0);
  expand_effects(sys, mode, state, curve_order, piece);
  watch_effects(sys, mode, curve_order, piece);
  return curve_order;
}

// The state `h` after the start of a piece; hidden states without an equation stay as they are.
template <class T>
void piece_state(const System<T>& sys, const Mode& mode, Piece<T>& piece, const State<T>& start, int order, const T& h,
                 T* z) {
  constexpr Effect owner[] = {fx_memory, fx_compliance, fx_droop, fx_lag};
  if constexpr (requires(T x) { x.d[0]; }) {
    for (int i = 0; i < 4; ++i) z[i] = evaluate_at(state_series(piece, i), order, h);
  } else {
    evaluate_four<T>({piece.s.x1, piece.s.x2, piece.s.y1, piece.s.y2}, order, h, z);
  }
  if (mode.contact == 0 && sys.structure.effects == 0) z[1] = sys.rig.v_b;
  if (sys.structure.effects == 0) {
    for (int i = hidden_w; i < state_count; ++i) z[i] = start.z[i];
    return;
  }
  for (int i = hidden_w; i < hidden_dwell; ++i)
    z[i] = has(sys, owner[i - hidden_w]) ? evaluate_at(state_series(piece, i), order, h) : start.z[i];
  if (piece.fx.lag_settles) z[hidden_m] = z[hidden_m] + piece.fx.lag_rest * exponential(-(h / sys.p[sensor_lag_tau]));
  z[hidden_dwell] = mode.contact == 0 ? start.z[hidden_dwell] + h : start.z[hidden_dwell];
}

template <class T>
void change_mode(const System<T>& sys, State<T>& s, Mode& mode, Side* on, int id, Side side, Piece<T>& piece) {
  if (sys.structure.effects == 0) {
    change_plain(sys, s, mode, on, side);
  } else {
    change_effects(sys, s, mode, on, id, side, piece);
  }
}

inline int sign_of(double x) { return x < 0 ? -1 : 1; }

// Everything discrete that the state decides except the contact.
template <class T>
void set_effect_modes(const System<T>& sys, const State<T>& s, Mode& mode, Side* on, Piece<T>& piece) {
  const auto real = [](const T& x) { return static_cast<double>(value(x)); };
  mode.x2_sign = sign_of(real(s.z[1]));
  if (has(sys, fx_gap)) {
    const double d = real(sys.p[spring_gap_k3_d]), y = real(s.z[2]);
    mode.gap = y > d ? 1 : (y < -d ? -1 : 0);
  }
  if (has(sys, fx_normal)) {
    const double n =
        real(T(1.0) + (sys.p[normal_force_feedback_beta2] * s.z[2] + sys.p[normal_force_feedback_eta2] * s.z[3]) /
                          sys.minus.static_limit);
    mode.lifted = n < 0;
  }
  if (has(sys, fx_table)) {
    for (int i = 0; i < 4; ++i) state_series(piece, i)[0] = s.z[i];
    const Structure& st = sys.structure;
    if (st.table_variable == TableVariable::t && st.table_period > 0)
      mode.cycle = static_cast<int>(std::floor(real(table_time(sys, mode, s.t, 0)) / st.table_period));
    belt_next(sys, piece.fx, s.t, 0);
    piece.fx.v[0] = s.z[1] - piece.fx.belt[0];
    variable_next(sys, mode, piece.s, piece.fx, s.t, 0);
    const double x = real(piece.fx.variable[0]);
    mode.knot = 0;
    while (mode.knot < st.knots && x >= st.knot[mode.knot]) ++mode.knot;
  }
  if (has(sys, fx_pivot) && creeps(sys)) {
    const double reach = creep_reach * real(sys.p[pivot_dry_friction_v_c]), y2 = real(s.z[3]);
    mode.pivot = y2 > reach ? 1 : (y2 < -reach ? -1 : 0);
  } else if (has(sys, fx_pivot)) {
    mode.pivot = real(s.z[3]) > 0 ? 1 : -1;
    if (real(s.z[3]) == 0) {
      State<T> copy = s;
      change_pivot(sys, copy, mode, on, Side::lower, piece);
    }
  }
}

// The mode at the start. |v_w| below 1e-12 of the speeds counts as rest: the block is set on the belt exactly.
template <class T>
void set_modes(const System<T>& sys, State<T>& s, Mode& mode, Side* on, int contact, Piece<T>& piece) {
  const auto real = [](const T& x) { return static_cast<double>(value(x)); };
  mode.contact = 0;
  piece.fx.b[0] = s.z[hidden_b];
  set_effect_modes(sys, s, mode, on, piece);
  piece.fx.belt[0] = sys.rig.v_b;
  if (sys.structure.effects != 0) belt_next(sys, piece.fx, s.t, 0);
  const T belt = piece.fx.belt[0];
  const double v = real(s.z[1] - belt);
  const double size = std::abs(real(belt)) > std::abs(real(s.z[1])) ? std::abs(real(belt)) : std::abs(real(s.z[1]));
  const bool rest = contact == 2 ? std::abs(v) <= 1e-12 * size : contact == 0;
  if (rest && sys.structure.effects == 0) {
    mode.contact = 1;  // as if a slip had just ended
    change_plain(sys, s, mode, on, Side::lower);
  } else if (rest) {
    const T dwell = s.z[hidden_dwell];
    s.z[1] = belt;
    settle_at_rest(sys, s, mode, on, piece);
    if (mode.contact == 0) s.z[hidden_dwell] = dwell;
  } else {
    mode.contact = contact == 2 ? sign_of(v) : contact;
    const Branch<T>& b = branch_of(sys, mode.contact);
    const T u = has(sys, fx_memory) ? s.z[hidden_w] : T(s.z[1] - belt);
    mode.w_sign = has(sys, fx_memory) && real(u) == 0 ? mode.contact : sign_of(real(u));
    mode.saturated = b.has_kink && std::abs(real(u)) >= real(b.kink);
    if (has(sys, fx_memory) && real(u) == 0) on[watch_memory] = Side::lower;
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
