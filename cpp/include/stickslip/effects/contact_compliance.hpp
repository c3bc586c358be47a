// Bristles: T = k z + c v, z' = v - k |v| z/R; the contact has no rigid stick.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct ContactCompliance {
  static constexpr Names<2> parameters{"k", "c"};
  static constexpr Hidden hidden{"z", 1};

  template <class T>
  struct Series {
    T moved[series_size], ratio[series_size];  // z |v|, and that by R
  };
  template <class T>
  static T contact(const At<ContactCompliance, T>& at, int k) {
    return at["k"] * at.hidden()[k] + at["c"] * at.v()[k];
  }
  template <class T>
  static T rate(const At<ContactCompliance, T>& at, int k) {
    if (at.contact() == 0) return T(0.0);
    auto& own = at.own();
    const T* kinetic = at.kinetic();
    own.moved[k] = product(at.hidden(), at.v(), k) * static_cast<double>(at.contact());
    const auto pressed = greater(value(kinetic[0]), Real<T>(0.0));  // lifted: the bristles are free
    const T over = T(1.0) / select(pressed, kinetic[0], T(1.0));
    own.ratio[k] = quotient_next(own.moved[k], kinetic, own.ratio, over, k);
    return select(pressed, at.v()[k] - at["k"] * own.ratio[k], T(0.0));
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
