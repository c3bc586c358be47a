// -k (y1 -+ d) on the angle body where |y1| > d; its side: -1 below -d, 1 above d.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct SpringGapK3 {
  static constexpr Names<2> parameters{"k", "d"};

  template <class T>
  static T angle_body(const At<SpringGapK3, T>& at, int k) {
    if (at.side() == 0) return T(0.0);
    return -(at["k"] * (at.y1()[k] - constant(at["d"] * static_cast<double>(at.side()), k)));
  }

  template <class T>
  static void watch(const At<SpringGapK3, T>& at, int order) {
    auto& w = at.watch(at.y1(), 1.0, order);
    const T d = at["d"];
    if (at.side() >= 0) above(w, at.side() > 0 ? d : -d);
    if (at.side() <= 0) below(w, at.side() < 0 ? -d : d);
  }
  template <class T>
  static void start(const Turn<SpringGapK3, T>& turn) {
    const double d = plain(turn["d"]), y = plain(turn.s.z[2]);
    turn.side() = y > d ? 1 : (y < -d ? -1 : 0);
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
