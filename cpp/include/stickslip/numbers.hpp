// What a trajectory is computed in: double, long double, Dual<N> (derivatives), Lanes<W> (several at once).
//
// The mathematics is written once over a number type T with these free functions:
//   value(x)            the real number(s) behind x
//   add_product(s,a,b)  s += a b
//   exponential, sine, cosine, square_root
#pragma once

#include <cmath>
#include <limits>

#include "stickslip/dual.hpp"
#include "stickslip/elementary.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
struct NumberTraits {
  using Real = T;
};
template <int N>
struct NumberTraits<Dual<N>> {
  using Real = double;
};
template <int W>
struct NumberTraits<Lanes<W>> {
  using Real = Lanes<W>;
};
template <class T>
using Real = typename NumberTraits<T>::Real;

inline double value(double x) { return x; }
inline long double value(long double x) { return x; }
template <int N>
double value(const Dual<N>& x) {
  return x.v;
}
template <int W>
Lanes<W> value(const Lanes<W>& x) {
  return x;
}

inline void add_product(double& s, double a, double b) { s += a * b; }
inline void add_product(long double& s, long double a, long double b) { s += a * b; }

inline double exponential(double x) { return detail::exp_poly<double, std::int64_t>(x); }
inline long double exponential(long double x) { return std::exp(x); }
template <int W>
Lanes<W> exponential(const Lanes<W>& x) {
  return Lanes<W>(detail::exp_poly<typename Lanes<W>::Vec, typename Lanes<W>::Bits>(x.v));
}
template <int N>
Dual<N> exponential(const Dual<N>& x) {
  const double e = exponential(x.v);
  return chain(x, e, e);
}

inline double sine(double x) { return std::sin(x); }
inline long double sine(long double x) { return std::sin(x); }
template <int N>
Dual<N> sine(const Dual<N>& x) {
  return chain(x, std::sin(x.v), std::cos(x.v));
}
inline double cosine(double x) { return std::cos(x); }
inline long double cosine(long double x) { return std::cos(x); }
template <int N>
Dual<N> cosine(const Dual<N>& x) {
  return chain(x, std::cos(x.v), -std::sin(x.v));
}
template <int W>
Lanes<W> sine(Lanes<W> x) {
  for (int i = 0; i < W; ++i) x.set(i, std::sin(x[i]));
  return x;
}
template <int W>
Lanes<W> cosine(Lanes<W> x) {
  for (int i = 0; i < W; ++i) x.set(i, std::cos(x[i]));
  return x;
}

inline double square_root(double x) { return std::sqrt(x); }
inline long double square_root(long double x) { return std::sqrt(x); }
template <int N>
Dual<N> square_root(const Dual<N>& x) {
  const double s = std::sqrt(x.v);
  return chain(x, s, s > 0 ? 0.5 / s : 0.0);
}

// Rough logarithm to base 2 of a positive real, the same in every width (step-size control must not depend on it).
inline double rough_log2(double x) { return detail::log2_rough<double, std::int64_t>(x); }
inline long double rough_log2(long double x) { return std::log2(x); }
template <int W>
Lanes<W> rough_log2(const Lanes<W>& x) {
  return Lanes<W>(detail::log2_rough<typename Lanes<W>::Vec, typename Lanes<W>::Bits>(x.v));
}

inline double rough_exp2(double x) { return detail::exp2_rough<double, std::int64_t>(x); }
inline long double rough_exp2(long double x) { return std::exp2(x); }
template <int W>
Lanes<W> rough_exp2(const Lanes<W>& x) {
  return Lanes<W>(detail::exp2_rough<typename Lanes<W>::Vec, typename Lanes<W>::Bits>(x.v));
}

template <class R>
R largest(R a, R b) {
  if constexpr (requires { a.v; }) {
    return max(a, b);
  } else {
    return a > b ? a : b;
  }
}
template <class R>
R smallest(R a, R b) {
  if constexpr (requires { a.v; }) {
    return min(a, b);
  } else {
    return a < b ? a : b;
  }
}
template <class R>
R magnitude(R a) {
  if constexpr (requires { a.v; }) {
    return abs(a);
  } else {
    return a < 0 ? -a : a;
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
