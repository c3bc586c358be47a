// The last terms of a series against the tolerance, and steps made shorter.
#pragma once

#include "stickslip/lanewise.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Leaves room for the error to add up over a cycle of stick-slip.
constexpr double tolerance_share = 0.1;

// Longest step whose last two terms stay below the tolerance (Jorba and Zou 2005).
template <class T>
Real<T> step_from(const Real<T>& last, const Real<T>& before, const Real<T>& scale, int order, double rtol,
                  double atol) {
  using R = Real<T>;
  const R tiny(1e-300);
  const R allowed = rough_log2((R(atol) + R(rtol) * scale) * tolerance_share + tiny);
  const R h1 = (allowed - rough_log2(last + tiny)) * (1.0 / order);
  const R h2 = (allowed - rough_log2(before + tiny)) * (1.0 / (order - 1));
  const R safety(-0.7 / (order - 1) * 1.4426950408889634);
  return rough_exp2(R(smallest(h1, h2) + safety));
}

// h of every lane, shortened until `allows(lane, h)`.
template <class R, class Allows>
R shortened(R h, const Allows& allows) {
  for (int i = 0; i < lane_count<R>; ++i) {
    double step = lane(h, i);
    for (int tries = 0; tries < 200 && !allows(i, step); ++tries) step *= 0.8;
    set_lane(h, i, step);
  }
  return h;
}

}  // namespace stickslip::inline STICKSLIP_ISA
