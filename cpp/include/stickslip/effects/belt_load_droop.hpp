// V = v_b + b, tau b' = k T - b.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct BeltLoadDroop {
  static constexpr Names<2> parameters{"k", "tau"};
  static constexpr Hidden hidden{"b", 2};

  template <class T>
  static T belt(const At<BeltLoadDroop, T>& at, int k) {
    return at.hidden()[k];
  }
  template <class T>
  static T belt_rate(const At<BeltLoadDroop, T>& at, int k) {
    return -(at.hidden()[k] / at["tau"]);
  }
  template <class T>
  static T belt_yield(const At<BeltLoadDroop, T>& at) {
    return at["k"] / at["tau"];
  }
  template <class T>
  static T rate(const At<BeltLoadDroop, T>& at, int k) {
    return (at["k"] * at.friction()[k] - at.hidden()[k]) / at["tau"];
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
