// Pairs of numbers that go through the same operations: the two exponentials of (4.2).
#pragma once

#include <type_traits>

#include "stickslip/numbers.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Two numbers handled alike: one register of two doubles, or simply two of anything else.
template <class T>
struct TwoOf {
  T a, b;
  TwoOf() = default;
  explicit TwoOf(double s) : a(s), b(s) {}
  TwoOf(const T& x, const T& y) : a(x), b(y) {}
  friend TwoOf operator*(const TwoOf& x, const TwoOf& y) { return {x.a * y.a, x.b * y.b}; }
  template <class S>
  friend TwoOf operator*(const TwoOf& x, const S& s) {
    return {x.a * s, x.b * s};
  }
  friend TwoOf operator+(const TwoOf& x, const TwoOf& y) { return {x.a + y.a, x.b + y.b}; }
};
template <class T>
using Pair = std::conditional_t<std::is_same_v<T, double>, Lanes<2>, TwoOf<T>>;

inline Lanes<2> paired(double a, double b) { return Lanes<2>(Lanes<2>::Vec{a, b}); }
inline double sum(const Lanes<2>& p) { return p[0] + p[1]; }
inline void add_product(Lanes<2>& s, double a, const Lanes<2>& b) { s.v += a * b.v; }
template <class T>
TwoOf<T> paired(const T& a, const T& b) {
  return {a, b};
}
template <class T>
T sum(const TwoOf<T>& p) {
  return p.a + p.b;
}
template <class T>
void add_product(TwoOf<T>& s, const T& a, const TwoOf<T>& b) {
  add_product(s.a, a, b.a);
  add_product(s.b, a, b.b);
}
template <class T>
TwoOf<T> exponential(const TwoOf<T>& x) {
  return {exponential(x.a), exponential(x.b)};
}

}  // namespace stickslip::inline STICKSLIP_ISA
