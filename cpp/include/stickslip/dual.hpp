// Dual<N>: a number that carries its derivatives with respect to N seeds.
//
// Forward mode, first order. Comparisons look at the value alone, so the mode machine takes the same path as it
// does in double, and what the path yields is differentiated exactly.
#pragma once

#include <cmath>

#include "stickslip/lanes.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <int N>
struct Dual {
  static_assert(N % 4 == 0);
  static constexpr int size = N, chunks = N / 4;
  using Chunk = Register<4>::Vec;  // vectors, so that the compiler keeps a dual number in registers
  double v;
  Chunk d[chunks];

  Dual() = default;  // uninitialised, as double is: series are filled before they are read
  constexpr Dual(double value) : v(value), d{} {}  // NOLINT(google-explicit-constructor): a constant is a number

  double derivative(int i) const { return d[i / 4][i % 4]; }
  void set_derivative(int i, double x) { d[i / 4][i % 4] = x; }

  Dual& operator+=(const Dual& o) {
    v += o.v;
    for (int i = 0; i < chunks; ++i) d[i] += o.d[i];
    return *this;
  }
  Dual& operator-=(const Dual& o) {
    v -= o.v;
    for (int i = 0; i < chunks; ++i) d[i] -= o.d[i];
    return *this;
  }
  Dual& operator*=(const Dual& o) {
    for (int i = 0; i < chunks; ++i) d[i] = d[i] * o.v + v * o.d[i];
    v *= o.v;
    return *this;
  }
  Dual& operator*=(double s) {
    v *= s;
    for (int i = 0; i < chunks; ++i) d[i] *= s;
    return *this;
  }
  Dual& operator/=(const Dual& o) {
    const double r = 1 / o.v;
    v *= r;
    for (int i = 0; i < chunks; ++i) d[i] = (d[i] - v * o.d[i]) * r;
    return *this;
  }

  friend Dual operator+(Dual a, const Dual& b) { return a += b; }
  friend Dual operator-(Dual a, const Dual& b) { return a -= b; }
  friend Dual operator*(Dual a, const Dual& b) { return a *= b; }
  friend Dual operator/(Dual a, const Dual& b) { return a /= b; }
  friend Dual operator+(Dual a, double b) {
    a.v += b;
    return a;
  }
  friend Dual operator+(double a, Dual b) { return b + a; }
  friend Dual operator-(Dual a, double b) {
    a.v -= b;
    return a;
  }
  friend Dual operator-(double a, const Dual& b) { return -b + a; }
  friend Dual operator*(Dual a, double b) { return a *= b; }
  friend Dual operator*(double a, Dual b) { return b *= a; }
  friend Dual operator/(Dual a, double b) { return a *= 1 / b; }
  friend Dual operator/(double a, const Dual& b) { return Dual(a) /= b; }
  friend Dual operator-(Dual a) {
    a.v = -a.v;
    for (int i = 0; i < chunks; ++i) a.d[i] = -a.d[i];
    return a;
  }
};

// f(a) with derivative df: the chain rule.
template <int N>
Dual<N> chain(const Dual<N>& a, double f, double df) {
  Dual<N> r(f);
  for (int i = 0; i < Dual<N>::chunks; ++i) r.d[i] = df * a.d[i];
  return r;
}

// acc + a b, the inner step of every convolution.
template <int N>
void add_product(Dual<N>& acc, const Dual<N>& a, const Dual<N>& b) {
  acc.v += a.v * b.v;
  for (int i = 0; i < Dual<N>::chunks; ++i) acc.d[i] += a.d[i] * b.v + a.v * b.d[i];
}

}  // namespace stickslip::inline STICKSLIP_ISA
