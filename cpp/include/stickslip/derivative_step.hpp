// How long a step of a run with derivatives may be: their own series against the tolerance.
#pragma once

#include "stickslip/by_seed.hpp"
#include "stickslip/step.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Derivatives have series of their own, which may be short of terms where the motion's is not: of a force whose amplitude
// is 0, of a hidden state that starts beside its slow manifold, about an equilibrium. h is shortened until the last two
// terms of each derivative are below the tolerance beside its own largest term.
constexpr double derivative_share = 1e3 * tolerance_share;  // beside its own largest term; the value has less room
constexpr double derivative_floor =
    1e-3;  // of the motion, for a change of a parameter by itself, or by 1 if it is less

struct NoSeeds {};

// Of the parameters; nothing without seeds.
template <class T>
auto change_by_seed(const System<T>& sys) {
  if constexpr (requires(T x) { x.d[0]; }) {
    return change_by_seed(sys.p.p, parameter_count);
  } else {
    return NoSeeds{};
  }
}

// What is nothing beside the motion need not be resolved: far from a narrow peak its derivatives are 1e-30 and grow.
template <class T>
BySeed<T> derivative_floors(const BySeed<T>& change, double motion) {
  BySeed<T> floors(derivative_floor * motion);
  for (int i = 0; i < T::chunks; ++i) floors.of[i] /= change.of[i];
  return floors;
}

template <class T>
double derivative_step(const System<T>& sys, const BySeed<T>& change, const Mode& mode, const State<T>& begin,
                       Piece<T>& piece, int order, double h, double rtol) {
  const double frequency = natural_frequency(sys), over_a1 = std::abs(sys.rig.over_a1.v);
  struct Row {
    const T* series;
    double weight;  // to a speed; of a force, to an acceleration
  };
  Row rows[7 + Effects::size];
  int count = 0;
  const auto add = [&](const T* series, double weight) { rows[count++] = {series, weight}; };
  add(piece.s.x1, frequency);
  add(piece.s.x2, 1);
  if (sys.rig.two) {
    add(piece.s.y1, frequency);
    add(piece.s.y2, 1);
  }
  if (sys.structure.effects != 0) {
    add(piece.fx.friction, over_a1);
    if (mode.contact == 0) add(piece.fx.limit_minus, over_a1);
    each_acting(sys, mode, begin, piece, [&](const auto& at) {
      using E = typename std::decay_t<decltype(at)>::Effect;
      if constexpr (requires { &E::template decides<T>; })
        if (const T* c = E::decides(at)) add(c, 1);
    });
    if (acts(sys, moves_belt)) add(piece.fx.belt, 1);
  }
  BySeed<T> floors(0.0);
  bool known = false;
  const auto raise = [&](BySeed<T>& into, int k, double power) {
    for (int row = 0; row < count; ++row) into.raise(rows[row].series[k], rows[row].weight * power);
  };
  const auto allows = [&](int, double step) {
    BySeed<T> largest_term = floors, last(0.0);
    const double power = std::pow(step, order - 1);
    raise(last, order - 1, power);
    raise(last, order, power * step);
    const auto small = [&] { return last.below(largest_term, derivative_share * rtol); };
    double now = 1;
    for (int k = 0; k < order - 1; ++k, now *= step) {
      raise(largest_term, k, now);
      if (k < 2 && small()) return true;  // nearly always
      if (k == 1 && !known) {
        floors = derivative_floors(change, largest(motion_scale(sys, piece.s), std::abs(sys.rig.v_b.v)));
        known = true;
        largest_term.raise(floors);
      }
    }
    return small();
  };
  return shortened(h, allows);
}

}  // namespace stickslip::inline STICKSLIP_ISA
