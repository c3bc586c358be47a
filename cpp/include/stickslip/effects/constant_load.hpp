// +f on the block.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct ConstantLoad {
  static constexpr Names<1> parameters{"f"};

  template <class T>
  static T block(const At<ConstantLoad, T>& at, int k) {
    return constant(at["f"], k);
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
