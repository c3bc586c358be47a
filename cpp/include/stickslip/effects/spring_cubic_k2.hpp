// -k (x1 + y1)^3 on the block and on the angle body.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct SpringCubicK2 {
  static constexpr Names<1> parameters{"k"};

  template <class T>
  struct Series {
    T sum[series_size], square[series_size], force;
  };
  template <class T>
  static void prepare(const At<SpringCubicK2, T>& at, int k) {
    auto& own = at.own();
    own.sum[k] = at.x1()[k] + at.y1()[k];
    own.force = -(at["k"] * cube_next(own.sum, own.square, k));
  }
  template <class T>
  static T block(const At<SpringCubicK2, T>& at, int) {
    return at.own().force;
  }
  template <class T>
  static T angle_body(const At<SpringCubicK2, T>& at, int) {
    return at.own().force;
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
