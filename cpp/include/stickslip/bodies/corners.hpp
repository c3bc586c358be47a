// Times at which a prescribed speed goes over to another piece.
#pragma once

#include "stickslip/bodies/kinks.hpp"
#include "stickslip/trajectory.hpp"

namespace stickslip::inline STICKSLIP_ISA {

inline int surface_order_for(double tol) {
  return order_for(tolerance_share * surface_tolerance(tol)) + surface_orders;
}

template <class T>
int piece_at(const BodiesSystem<T>& sys, int speed, double t) {
  const SpeedTape& tape = sys.b->speed[speed];
  int piece = 0;
  while (piece + 1 < tape.count && tape.begins[piece + 1] <= t) ++piece;
  return piece;
}

template <class T>
Real<T> next_corner(const BodiesSystem<T>& sys) {
  Real<T> first(std::numeric_limits<double>::infinity());
  for (int i = 0; i < sys.speeds; ++i) {
    const SpeedTape& tape = sys.b->speed[i];
    const int next = sys.rail[i].now + 1;
    if (next < tape.count) first = smallest(first, Real<T>(tape.begins[next]));
  }
  return first;
}

// Where a push reads the size of a prescribed speed that jumps, its new value says on which side.
template <class T>
void forget_jumped_sides(Tape<T>& tape) {
  for (int i = 0; i < tape.formulas->count; ++i)
    if (is_piecewise(tape.at(i).op) && tape.at(tape.at(i).a).op == Op::prescribed) tape.node[i].side = 0;
}

// Takes every speed to its piece at t, and the modes along.
template <class T>
void turn_corners(BodiesSystem<T>& sys, BodiesState<T>& s, const Real<T>& t, Side* on) {
  set_first(sys, s);
  link_speeds(sys);
  expand_speeds(sys, 0);
  for (int i = 0; i < sys.speeds; ++i) {
    const SpeedTape& tape = sys.b->speed[i];
    Rail<T>& rail = sys.rail[i];
    rail.before = static_cast<double>(value(sys.V[i * series_size]));
    rail.size = std::max(rail.size, std::abs(rail.before));
    while (rail.now + 1 < tape.count && tape.begins[rail.now + 1] <= t) ++rail.now;
  }
  for (int e = 0; e < sys.pushes; ++e) forget_jumped_sides(sys.push[e].tape);
  set_bodies_modes(sys, s, nullptr, false, on);
}

}  // namespace stickslip::inline STICKSLIP_ISA
