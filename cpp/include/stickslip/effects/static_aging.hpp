// dT (1 - e^(-dwell/tau)) on the static limits; dwell is the time at rest.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct StaticAging {
  static constexpr Names<2> parameters{"dT", "tau"};
  static constexpr Hidden hidden{"dwell", 4};

  template <class T>
  struct Series {
    T rest[series_size];
  };
  template <class T>
  static T limit(const At<StaticAging, T>& at, int k) {
    T* rest = at.own().rest;
    const T over = T(1.0) / at["tau"];
    rest[k] = k == 0 ? at["dT"] * exponential(-(at.hidden_start() * over)) : -(rest[k - 1] * over) * inverse<T>(k);
    return constant(at["dT"], k) - rest[k];
  }
  template <class T>
  static T state(const At<StaticAging, T>& at, const T& dwell, const T& h) {
    return at.contact() == 0 ? dwell + h : dwell;
  }
  template <class T>
  static void halts(const Turn<StaticAging, T>& turn) {
    turn.hidden() = T(0.0);
  }
  template <class T>
  static void changes(const Turn<StaticAging, T>& turn, int) {
    if (turn.mode.contact != 0) turn.hidden() = T(0.0);
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
