// How a trajectory is computed; and what rests but for rounding.
#pragma once

#include "stickslip/piece.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct Options {
  double rtol, atol, t_end;
  bool henon;
  int order;          // of the series of a curved piece
  double fixed_step;  // 0: from the tolerance
  long max_transitions, max_steps = most_steps;
};

inline int order_for(double tol) {  // Jorba and Zou 2005: p = 1 - ln(tol)/2, and one more
  const int order = static_cast<int>(3.0 - 0.5 * std::log(tol > 1e-18 ? tol : 1e-18));
  return order < 4 ? 4 : (order > max_order ? max_order : order);
}

constexpr double resting = 1e-9;  // of a motion's own rate

// Is a surface that of an effect that does not jump there?
inline bool is_smooth(int watch) {
  const auto one = [&]<class E> {
    if constexpr (requires { E::smooth; }) return watch == effect_watch<E>;
    return false;
  };
  return [&]<class... E>(TypeList<E...>) { return (one.template operator()<E>() || ...); }(Effects{});
}

// A surface where nothing jumps, met by a block that rests but for rounding: the time of that has no derivative, and none
// is needed.
template <class T>
bool hardly_moves(const System<T>& sys, const Piece<T>& piece, const Watch<T>& w, int order, const Real<T>& h) {
  using R = Real<T>;
  if (sys.structure.effects == 0 || !is_smooth(w.id)) return false;
  R rate(0.0);
  for (int k = order; k >= 1; --k) rate = rate * h + R(value(w.c[k])) * static_cast<double>(k);
  return magnitude(rate) < resting * motion_scale(sys, piece.s) * natural_frequency(sys);
}

}  // namespace stickslip::inline STICKSLIP_ISA
