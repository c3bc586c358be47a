// The functions that only formulas use, in every number type.
#pragma once

#include "stickslip/numbers.hpp"

namespace stickslip::inline STICKSLIP_ISA {

inline double logarithm(double x) { return std::log(x); }
inline long double logarithm(long double x) { return std::log(x); }
template <int N>
Dual<N> logarithm(const Dual<N>& x) {
  return chain(x, std::log(x.v), 1 / x.v);
}
inline double tangent(double x) { return std::tan(x); }
inline long double tangent(long double x) { return std::tan(x); }
template <int N>
Dual<N> tangent(const Dual<N>& x) {
  const double y = std::tan(x.v);
  return chain(x, y, 1 + y * y);
}
inline double hyperbolic_tangent(double x) { return std::tanh(x); }
inline long double hyperbolic_tangent(long double x) { return std::tanh(x); }
template <int N>
Dual<N> hyperbolic_tangent(const Dual<N>& x) {
  const double y = std::tanh(x.v);
  return chain(x, y, 1 - y * y);
}
inline double area_sine(double x) { return std::asinh(x); }
inline long double area_sine(long double x) { return std::asinh(x); }
template <int N>
Dual<N> area_sine(const Dual<N>& x) {
  return chain(x, std::asinh(x.v), 1 / std::sqrt(1 + x.v * x.v));
}

// x^p for x >= 0, and for any x where p is whole.
inline double raised(double x, double p) { return std::pow(x, p); }
inline long double raised(long double x, long double p) { return std::pow(x, p); }
template <int N>
Dual<N> raised(const Dual<N>& x, const Dual<N>& p) {
  const double y = std::pow(x.v, p.v);
  Dual<N> r(y);
  const double by_x = p.v == 0 ? 0.0 : p.v * std::pow(x.v, p.v - 1);
  const double by_p = x.v > 0 ? y * std::log(x.v) : 0.0;
  for (int i = 0; i < Dual<N>::chunks; ++i) r.d[i] = (x.v == 0 && p.v < 1 ? 0.0 : by_x) * x.d[i] + by_p * p.d[i];
  return r;
}

// Does it carry no derivatives?
template <class T>
bool is_plain(const T& x) {
  if constexpr (requires { x.d[0]; }) {
    for (int i = 0; i < T::size; ++i)
      if (x.derivative(i) != 0) return false;
  }
  return true;
}

}  // namespace stickslip::inline STICKSLIP_ISA
