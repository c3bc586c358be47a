// -k y1^3 on the angle body.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct SpringCubicK3 {
  static constexpr Names<1> parameters{"k"};

  template <class T>
  struct Series {
    T square[series_size];
  };
  template <class T>
  static T angle_body(const At<SpringCubicK3, T>& at, int k) {
    return -(at["k"] * cube_next(at.y1(), at.own().square, k));
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
