// Friction times 1 + r t.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct FrictionDrift {
  static constexpr Names<1> parameters{"r"};

  template <class T>
  static T share(const At<FrictionDrift, T>& at, int k) {
    return k == 0 ? at["r"] * at.t() : constant(at["r"], k - 1);
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
