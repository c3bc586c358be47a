// What one trajectory asks for alone, on a named rig (kernel.cpp) and on one of bodies (bodies_kernel.cpp).
#pragma once

#include <algorithm>

#include "stickslip/trajectory.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// A trajectory alone is fastest with a higher order and a tighter tolerance than lanes are; measured by bench_p1.
constexpr double alone_share = 0.3;
constexpr int alone_order = 4;

// Options of a request, `order` of its own where it is above 0.
template <class Q>
Options options_alone(const Q& q, int order, double fixed_step) {
  const double tightest = q.rtol > 0 ? q.rtol : q.atol;
  const int by_tolerance = std::min(order_for(tolerance_share * alone_share * tightest) + alone_order, max_order);
  return {alone_share * q.rtol,
          alone_share * q.atol,
          q.t_end,
          q.locator == stickslip_abi::Locator::henon,
          order > 0 ? order : by_tolerance,
          fixed_step,
          q.max_transitions,
          q.max_steps};
}

// Copies values and derivatives of `n` numbers for the caller; derivatives are laid out n x seeds.
template <class T>
void unpack(const T* z, int n, int seeds, double* values, double* derivatives) {
  for (int i = 0; i < n; ++i) {
    values[i] = static_cast<double>(value(z[i]));
    if constexpr (requires(T x) { x.d[0]; })
      for (int k = 0; k < seeds; ++k) derivatives[i * seeds + k] = z[i].derivative(k);
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
