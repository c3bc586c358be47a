// Everything a trajectory needs to know of its model, built once from the parameters.
#pragma once

#include "stickslip/rig.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// A linear piece is expanded to machine precision whatever the tolerance: its series converges everywhere, so the
// step depends on the rig alone. With rate >= |A|, the terms left out are below (rate h)^26/26! of the motion.
constexpr int linear_order = 25;
constexpr double linear_reach = 1.95;  // rate h: (1.95)^26/26! = 9e-20, and e^1.95 bounds the cancellation
constexpr double line_forever = 1e12;  // step of a block in stick, which is on a line: its powers stay finite

template <class T>
struct System {
  Parameters<T> p;
  Rig<T> rig;
  Branch<T> minus, plus;
  Structure structure;
  Real<T> stick_step, floor_step, line_step;  // of linear pieces: at rest, on a floor, along a line
  Real<T> frequency;                          // of the block on its spring
  T table[table_count][max_knots + 1][4];     // cubic of each interval in (variable - its left knot); constant outside
};

template <class T>
void build_law(System<T>& sys) {
  sys.minus = branch(sys.structure.law, sys.p, -1);
  sys.plus = branch(sys.structure.law, sys.p, 1);
}
template <class T>
void build_rig(System<T>& sys) {  // after the law
  sys.rig = make_rig(sys.structure.rig, sys.p);
  const Rig<T>& r = sys.rig;
  const auto real = [](const T& x) { return magnitude(value(x)); };
  // rates of |A|: root of the stiffness plus the damping, row by row; of the leg alone in stick
  const auto block = [&](const Real<T>& slope) {
    return square_root(real(r.kx) + real(r.s * r.over_a1)) + (real(r.e1) * 2.0 + slope) * real(r.over_a1);
  };
  const Real<T> leg = square_root((real(r.b3) + 1.0) * real(r.over_a2)) + (real(r.e1) + real(r.e12)) * real(r.over_a2);
  const auto rate = [&](const Real<T>& slope) { return r.two ? largest(block(slope), leg) : block(slope); };
  const Real<T> reach(linear_reach);
  sys.stick_step = r.two ? reach / leg : Real<T>(line_forever);
  sys.floor_step = reach / rate(Real<T>(0.0));
  sys.line_step = reach / rate(largest(Real<T>(real(sys.minus.c1)), Real<T>(real(sys.plus.c1))));
  sys.frequency = square_root(Real<T>(value(r.kx)));
}
template <class T>
void build(System<T>& sys) {  // from sys.structure and sys.p
  build_law(sys);
  build_rig(sys);
}

template <class T>
const Branch<T>& branch_of(const System<T>& sys, int contact) {
  return contact < 0 ? sys.minus : sys.plus;
}

}  // namespace stickslip::inline STICKSLIP_ISA
