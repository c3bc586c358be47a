// -c x2 on the block.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct BlockViscousDamping {
  static constexpr Names<1> parameters{"c"};

  template <class T>
  static T block(const At<BlockViscousDamping, T>& at, int k) {
    return -(at["c"] * at.x2()[k]);
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
