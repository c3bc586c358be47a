// V = v_b (1 + a sin(w t + phi)).
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct BeltSpeedRipple {
  static constexpr Names<3> parameters{"a", "w", "phi"};

  template <class T>
  using Series = Oscillation<T>;
  template <class T>
  static T belt(const At<BeltSpeedRipple, T>& at, int k) {
    return at.own().next(at["a"] * at.sys.rig.v_b, at["w"], at["phi"], at.t(), k);
  }
  template <class T>
  static T belt_rate(const At<BeltSpeedRipple, T>& at, int k) {
    return at["w"] * at.own().cos[k];
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
