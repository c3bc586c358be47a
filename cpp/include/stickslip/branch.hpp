// One direction of slip of a friction law: its magnitude R(u) over u = |v_w|, as data.
//
//   R(u) = c0 + c1 u + curve(u)   below the kink, = saturated from the kink on;
// `curve` is what a law has beyond a line (friction/*.hpp), with numbers of its own.
#pragma once

#include <limits>

#include "stickslip/series.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr int straight = -1;      // a branch without a curve
constexpr int own_curve = -2;     // one with the curve of the law that makes it
constexpr int curve_numbers = 6;  // the most that a curve may have

template <class T>
struct Branch {
  T static_limit;  // what the contact holds at rest
  T c0, c1;
  T own[curve_numbers];  // of the curve
  T saturated;
  T kink;  // u at which R falls to `saturated`
  bool has_kink = false;
  int curve = straight;  // or the place of the law whose curve it is
};

// Coefficient k of a constant.
template <class T>
T constant(const T& c, int k) {
  return k == 0 ? c : T(0.0);
}

template <class L, class T>
T curve_of(const Branch<T>& b, const T& u) {
  return b.c0 + b.c1 * u + L::curve(b.own, u);
}
template <class L, class T>
T slope_of(const Branch<T>& b, const T& u) {
  return b.c1 + L::slope(b.own, u);
}

// Where the falling curve meets its floor: Newton's steps inside a bracket on the values, then some in T, which make the
// derivatives of the kink exact (and its value, to rounding).
template <class L, class T>
T saturation_speed(const Branch<T>& b, double start) {
  const auto above = [&](double u) { return static_cast<double>(value(curve_of<L>(b, T(u)) - b.saturated)); };
  if (above(0.0) <= 0) return T(0.0);
  double lo = 0, hi = start;
  for (int i = 0; i < 60 && above(hi) > 0; ++i) hi *= 2;
  if (above(hi) > 0) return T(std::numeric_limits<double>::infinity());
  double at = 0.5 * (lo + hi), last = hi;
  for (int i = 0; i < 100 && last > 1e-12 * hi; ++i) {
    const double height = above(at);
    (height > 0 ? lo : hi) = at;
    double next = at - height / static_cast<double>(value(slope_of<L>(b, T(at))));
    if (!(next > lo && next < hi) || std::abs(next - at) > 0.75 * last) next = 0.5 * (lo + hi);
    last = std::abs(next - at);
    at = next;
  }
  T u(at);
  for (int i = 0; i < 3; ++i)
    u = T(value(u)) - (curve_of<L>(b, T(value(u))) - b.saturated) / slope_of<L>(b, T(value(u)));
  return u;
}

}  // namespace stickslip::inline STICKSLIP_ISA
