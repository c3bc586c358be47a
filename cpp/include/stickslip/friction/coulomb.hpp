// Coulomb's law: R(u) = kinetic, whatever the speed.
#pragma once

#include "stickslip/branch.hpp"
#include "stickslip/names.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct Coulomb {
  static constexpr Names<4> parameters{"static_minus", "kinetic_minus", "static_plus", "kinetic_plus"};

  template <class T>
  static Branch<T> branch(const Numbers<Coulomb, T>& p, int direction) {
    const bool minus = direction < 0;
    Branch<T> b{};
    b.static_limit = minus ? p["static_minus"] : p["static_plus"];
    b.c0 = minus ? p["kinetic_minus"] : p["kinetic_plus"];
    return b;
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
