// +a sin(w t + phi) on the block.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct HarmonicForcing {
  static constexpr Names<3> parameters{"a", "w", "phi"};

  template <class T>
  using Series = Oscillation<T>;
  template <class T>
  static T block(const At<HarmonicForcing, T>& at, int k) {
    return at.own().next(at["a"], at["w"], at["phi"], at.t(), k);
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
