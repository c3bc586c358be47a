// Decisions that a real or several in lanes may take differently: comparisons, choices, one lane at a time.
#pragma once

#include "stickslip/numbers.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// A comparison of reals, and a choice by it: a bool, or lane by lane.
template <class R>
auto greater(const R& a, const R& b) {
  if constexpr (requires { a.v; }) {
    return a.v > b.v;
  } else {
    return a > b;
  }
}
template <class T>
T select(bool first, const T& a, const T& b) {
  return first ? a : b;
}
template <int W>
Lanes<W> select(const typename Lanes<W>::Bits& first, const Lanes<W>& a, const Lanes<W>& b) {
  return Lanes<W>(first ? a.v : b.v);
}

// One lane of a real, for what is decided lane by lane.
template <class R>
constexpr int lane_count = 1;
template <int W>
constexpr int lane_count<Lanes<W>> = W;
template <class R>
double lane(const R& x, int i) {
  if constexpr (requires { x.v; }) {
    return x[i];
  } else {
    return static_cast<double>(x);
  }
}
template <class R>
void set_lane(R& x, int i, double to) {
  if constexpr (requires { x.v; }) {
    x.set(i, to);
  } else {
    x = to;
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
