// -c x2 |x2| on the block; its side is the sign of x2.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct BlockQuadraticDamping {
  static constexpr Names<1> parameters{"c"};
  static constexpr bool smooth = true;

  template <class T>
  struct Series {
    T square[series_size];
  };
  template <class T>
  static T block(const At<BlockQuadraticDamping, T>& at, int k) {
    T* square = at.own().square;
    square[k] = product(at.x2(), at.x2(), k);
    return -(at["c"] * square[k] * static_cast<double>(at.side()));
  }

  template <class T>
  static void watch(const At<BlockQuadraticDamping, T>& at, int order) {
    auto& w = at.watch(at.x2(), at.side(), order);
    above(w, T(0.0));
    w.rounding = at.speed_rounding();
  }
  template <class T>
  static void start(const Turn<BlockQuadraticDamping, T>& turn) {
    turn.side() = plain(turn.s.z[1]) < 0 ? -1 : 1;
  }
  template <class T>
  static void cross(const Turn<BlockQuadraticDamping, T>& turn, auto through) {
    turn.side() = -turn.side();
    turn.stands() = through;
  }
  template <class T>
  static void changes(const Turn<BlockQuadraticDamping, T>& turn, int) {
    if (turn.mode.contact == 0 || value(turn.s.z[1]) != 0) return;
    turn.side() = turn.mode.contact;  // off a belt at rest: x2 has the sign of v_w
    turn.stands_inside();
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
