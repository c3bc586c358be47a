// The laws (4.1)-(4.3): magnitudes R(u), u = |v_w|, one branch for each direction of slip.
//
//   R(u) = c0 + c1 u + c2 u^2 + rational/(1 + decay u) - a1 e^(k1 u) - a2 e^(k2 u)   below the kink,
//        = saturated                                                                from the kink on.
// T_- is (4.2) with the exponent 0.28 - u and the floor T_min; T_+ is the line (4.1) with its floor.
#pragma once

#include <limits>

#include "stickslip/parameters.hpp"

namespace stickslip::inline STICKSLIP_ISA {

enum class Shape { line, exponentials, rational };

template <class T>
struct Branch {
  T static_limit;  // what the contact holds at rest
  T c0, c1, c2;
  T rational, decay;
  T a1, k1, a2, k2;
  T saturated;
  T kink;  // u at which R falls to `saturated`
  bool has_kink = false;
  Shape shape = Shape::line;
};

template <class T>
T curve(const Branch<T>& b, const T& u) {
  T r = b.c0 + u * (b.c1 + u * b.c2);
  if (b.shape == Shape::exponentials) r = r - b.a1 * exponential(b.k1 * u) - b.a2 * exponential(b.k2 * u);
  if (b.shape == Shape::rational) r = r + b.rational / (T(1.0) + b.decay * u);
  return r;
}

template <class T>
T curve_slope(const Branch<T>& b, const T& u) {
  T r = b.c1 + 2.0 * u * b.c2;
  if (b.shape == Shape::exponentials) r = r - b.a1 * b.k1 * exponential(b.k1 * u) - b.a2 * b.k2 * exponential(b.k2 * u);
  if (b.shape == Shape::rational) {
    const T d = T(1.0) + b.decay * u;
    r = r - b.rational * b.decay / (d * d);
  }
  return r;
}

// Kinetic magnitude at u >= 0, saturation included.
template <class T>
T magnitude(const Branch<T>& b, const T& u) {
  if (b.has_kink && value(u) >= value(b.kink)) return b.saturated;
  return curve(b, u);
}

// Where the falling curve meets its floor: Newton's steps inside a bracket on the values, then some in T, which make the
// derivatives of the kink exact (and its value, to rounding).
template <class T>
T saturation_speed(const Branch<T>& b, double start) {
  const auto above = [&](double u) { return static_cast<double>(value(curve(b, T(u)) - b.saturated)); };
  if (above(0.0) <= 0) return T(0.0);
  double lo = 0, hi = start;
  for (int i = 0; i < 60 && above(hi) > 0; ++i) hi *= 2;
  if (above(hi) > 0) return T(std::numeric_limits<double>::infinity());
  double at = 0.5 * (lo + hi), last = hi;
  for (int i = 0; i < 100 && last > 1e-12 * hi; ++i) {
    const double height = above(at);
    (height > 0 ? lo : hi) = at;
    double next = at - height / static_cast<double>(value(curve_slope(b, T(at))));
    if (!(next > lo && next < hi) || std::abs(next - at) > 0.75 * last) next = 0.5 * (lo + hi);
    last = std::abs(next - at);
    at = next;
  }
  T u(at);
  for (int i = 0; i < 3; ++i) u = T(value(u)) - (curve(b, T(value(u))) - b.saturated) / curve_slope(b, T(value(u)));
  return u;
}

template <class T>
Branch<T> paper_minus(const Parameters<T>& p) {  // (4.2)
  Branch<T> b{};
  b.shape = Shape::exponentials;
  b.static_limit = b.c0 = p[T_s_minus];
  b.k1 = T(1.0) / p[t1];
  b.k2 = T(1.0) / p[t2];
  b.a1 = p[A1] * exponential(p[v_w_min] * b.k1);  // v_w_min = -0.28: e^(-(0.28 - u)/t1)
  b.a2 = p[A2] * exponential(p[v_w_min] * b.k2);
  b.saturated = p[T_min_minus];
  b.has_kink = true;
  b.kink = saturation_speed(b, -static_cast<double>(value(p[v_w_min])));
  return b;
}

template <class T>
Branch<T> paper_plus(const Parameters<T>& p) {  // (4.1)
  Branch<T> b{};
  b.static_limit = b.c0 = p[T_s_plus];
  b.c1 = (p[T_min_plus] - p[T_s_plus]) / p[v_w_max];
  b.saturated = p[T_min_plus];
  b.has_kink = true;
  b.kink = p[v_w_max];
  return b;
}

template <class T>
Branch<T> coulomb(const T& static_limit, const T& kinetic) {
  Branch<T> b{};
  b.static_limit = static_limit;
  b.c0 = kinetic;
  return b;
}

template <class T>
Branch<T> hyperbolic(const T& scale, const T& decay, const T& constant, const T& quadratic) {
  Branch<T> b{};
  b.shape = Shape::rational;
  b.rational = scale;
  b.decay = decay;
  b.c0 = constant;
  b.c2 = quadratic;
  b.static_limit = scale + constant;
  return b;
}

// A curve that starts at or below its floor is all floor.
template <class T>
Branch<T> without_empty_curve(const Branch<T>& b) {
  return !b.has_kink || value(b.kink) > 0 ? b : coulomb(b.static_limit, b.saturated);
}

template <class T>
Branch<T> any_branch(LawKind law, const Parameters<T>& p, int direction) {
  const bool minus = direction < 0;
  switch (law) {
    case LawKind::coulomb:
      return minus ? coulomb(p[static_minus], p[kinetic_minus]) : coulomb(p[static_plus], p[kinetic_plus]);
    case LawKind::hyperbolic:
      return minus ? hyperbolic(p[scale_minus], p[decay_minus], p[constant_minus], p[quadratic_minus])
                   : hyperbolic(p[scale_plus], p[decay_plus], p[constant_plus], p[quadratic_plus]);
    default: return minus ? paper_minus(p) : paper_plus(p);
  }
}

// direction -1: slip with v_w < 0; +1: slip with v_w > 0.
template <class T>
Branch<T> branch(LawKind law, const Parameters<T>& p, int direction) {
  return without_empty_curve(any_branch(law, p, direction));
}

}  // namespace stickslip::inline STICKSLIP_ISA
