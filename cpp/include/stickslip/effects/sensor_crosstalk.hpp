// +c y1 on the reading of x1. The motion does not feel it; a lag follows it.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct SensorCrosstalk {
  static constexpr Names<1> parameters{"c"};

  template <class T>
  static T reading(const At<SensorCrosstalk, T>& at, int k) {
    return at["c"] * at.y1()[k];
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
