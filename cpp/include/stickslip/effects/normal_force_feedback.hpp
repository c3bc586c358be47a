// Friction times 1 + (beta2 y1 + eta2 y2)/static_minus, never below 0; its side: -1 where the contact is lifted.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct NormalForceFeedback {
  static constexpr Names<2> parameters{"beta2", "eta2"};

  template <class T>
  struct Series {
    T normal[series_size];
  };
  template <class T>
  static T share(const At<NormalForceFeedback, T>& at, int k) {
    const T rise = (at["beta2"] * at.y1()[k] + at["eta2"] * at.y2()[k]) / at.sys.minus.static_limit;
    at.own().normal[k] = rise + constant(T(1.0), k);
    return at.side() < 0 ? constant(T(-1.0), k) : rise;
  }

  template <class T>
  static void watch(const At<NormalForceFeedback, T>& at, int order) {
    auto& w = at.watch(at.own().normal, 1.0, order);
    at.side() < 0 ? below(w, T(0.0)) : above(w, T(0.0));
  }
  template <class T>
  static void start(const Turn<NormalForceFeedback, T>& turn) {
    const T rise = (turn["beta2"] * turn.s.z[2] + turn["eta2"] * turn.s.z[3]) / turn.sys.minus.static_limit;
    turn.side() = plain(T(1.0) + rise) < 0 ? -1 : 0;
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
