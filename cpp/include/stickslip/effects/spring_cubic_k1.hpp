// -k x1^3 on the block.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct SpringCubicK1 {
  static constexpr Names<1> parameters{"k"};

  template <class T>
  struct Series {
    T square[series_size];
  };
  template <class T>
  static T block(const At<SpringCubicK1, T>& at, int k) {
    return -(at["k"] * cube_next(at.x1(), at.own().square, k));
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
