// Friction times 1 + a sin(2 pi (v_b t - x1)/L + phi).
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct BeltSeam {
  static constexpr Names<3> parameters{"a", "L", "phi"};

  template <class T>
  struct Series {
    T slope[series_size], sin[series_size], cos[series_size];
  };
  template <class T>
  static T share(const At<BeltSeam, T>& at, int k) {
    auto& own = at.own();
    const T turn = 6.283185307179586477 / at["L"];
    const T& v_b = at.sys.rig.v_b;
    if (k == 0) {
      const T angle = turn * (v_b * at.t() - at.x1()[0]) + at["phi"];
      own.sin[0] = at["a"] * sine(angle);
      own.cos[0] = at["a"] * cosine(angle);
    } else {
      own.slope[k] = turn * (constant(v_b, k - 1) - at.x1()[k]) * static_cast<double>(k);
      own.sin[k] = rotation_next(own.slope, own.cos, k);
      own.cos[k] = -rotation_next(own.slope, own.sin, k);
    }
    return own.sin[k];
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
