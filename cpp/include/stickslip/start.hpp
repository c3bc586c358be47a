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
  watch_effects(sys, mode, state, curve_order, piece);
  return curve_order;
}

// The state `h` after the start of a piece; hidden states without an equation stay as they are. Those of the bits `plain`
// have no derivatives.
template <class T>
void piece_state(const System<T>& sys, const Mode& mode, Piece<T>& piece, const State<T>& start, int order, const T& h,
                 T* z, std::uint32_t plain = 0) {
  const auto is_plain = [&](int i) { return (plain >> i & 1) != 0; };
  if constexpr (requires(T x) { x.d[0]; }) {
    for (int i = 0; i < 2; ++i) {  // a place of the block and one of the angle body: as many as stay in registers
      const T *block = state_series(piece, i), *angle = state_series(piece, i + 2);
      if (is_plain(i) && is_plain(i + 2)) {
        z[i] = T(evaluate_value(block, order, h.v));
        z[i + 2] = T(evaluate_value(angle, order, h.v));
      } else {
        evaluate_both_at(block, angle, order, h, z[i], z[i + 2]);
      }
    }
  } else {
    evaluate_four<T>({piece.s.x1, piece.s.x2, piece.s.y1, piece.s.y2}, order, h, z);
  }
  if (mode.contact == 0 && sys.structure.effects == 0) z[1] = sys.rig.v_b;
  for (int i = visible_count; i < state_count; ++i) z[i] = start.z[i];
  if (sys.structure.effects == 0) return;
  each_acting(sys, mode, start, piece, [&](const auto& at) {
    using E = typename std::decay_t<decltype(at)>::Effect;
    if constexpr (requires { E::hidden; }) {
      T& own = z[state_of<E>];
      if constexpr (requires { &E::template rate<T>; }) own = evaluate_at(at.hidden(), order, h);
      if constexpr (requires { &E::template state<T>; }) own = E::state(at, own, h);
    }
  });
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

// The mode at the start. |v_w| below 1e-12 of the speeds counts as rest: the block is set on the belt exactly.
template <class T>
void set_modes(const System<T>& sys, State<T>& s, Mode& mode, Side* on, int contact, Piece<T>& piece) {
  mode.contact = 0;
  piece.fx.belt[0] = sys.rig.v_b;
  if (sys.structure.effects != 0) set_effect_modes(sys, s, mode, on, piece);
  const T belt = piece.fx.belt[0];
  const double v = plain(T(s.z[1] - belt)), size = largest(std::abs(plain(belt)), std::abs(plain(s.z[1])));
  const bool rest = contact == 2 ? std::abs(v) <= 1e-12 * size : contact == 0;
  if (rest && sys.structure.effects == 0) {
    mode.contact = 1;  // as if a slip had just ended
    change_plain(sys, s, mode, on, Side::lower);
  } else if (rest) {
    s.z[1] = belt;
    settle_at_rest(sys, s, mode, on, piece);
  } else {
    mode.contact = contact == 2 ? sign_of(v) : contact;
    const Branch<T>& b = branch_of(sys, mode.contact);
    mode.saturated = b.has_kink && std::abs(v) >= plain(b.kink);
    each_turn(sys, s, mode, on, piece, [](const auto& turn) {
      using E = typename std::decay_t<decltype(turn)>::Effect;
      if constexpr (requires { &E::template slips<T>; }) E::slips(turn);
    });
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
