// Lanes<W>: W trajectories in one register; arithmetic lane by lane, comparisons give masks.
//
// The compiler's vector types do the work (a vector wider than the machine's is split by the compiler), so that one
// source serves SSE2, AVX2 and AVX-512.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#ifdef __SSE2__
#include <immintrin.h>
#endif

#include "stickslip/isa.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Spelled out: the compiler drops the attribute where the size depends on a template parameter.
template <int W>
struct Register;
template <>
struct Register<2> {
  using Vec [[gnu::vector_size(16)]] = double;
  using Bits [[gnu::vector_size(16)]] = std::int64_t;
};
template <>
struct Register<4> {
  using Vec [[gnu::vector_size(32)]] = double;
  using Bits [[gnu::vector_size(32)]] = std::int64_t;
};
template <>
struct Register<8> {
  using Vec [[gnu::vector_size(64)]] = double;
  using Bits [[gnu::vector_size(64)]] = std::int64_t;
};
template <>
struct Register<16> {
  using Vec [[gnu::vector_size(128)]] = double;
  using Bits [[gnu::vector_size(128)]] = std::int64_t;
};

template <int W>
struct Lanes {
  static constexpr int size = W;
  using Vec = typename Register<W>::Vec;
  using Bits = typename Register<W>::Bits;
  Vec v;

  Lanes() = default;                 // uninitialised, as double is
  Lanes(double s) : v(s - Vec{}) {}  // NOLINT(google-explicit-constructor): a constant is a number
  explicit Lanes(Vec x) : v(x) {}

  double operator[](int i) const { return v[i]; }
  void set(int i, double x) { v[i] = x; }

  Lanes& operator+=(const Lanes& o) {
    v += o.v;
    return *this;
  }
  Lanes& operator-=(const Lanes& o) {
    v -= o.v;
    return *this;
  }
  Lanes& operator*=(const Lanes& o) {
    v *= o.v;
    return *this;
  }
  friend Lanes operator+(const Lanes& a, const Lanes& b) { return Lanes(a.v + b.v); }
  friend Lanes operator-(const Lanes& a, const Lanes& b) { return Lanes(a.v - b.v); }
  friend Lanes operator*(const Lanes& a, const Lanes& b) { return Lanes(a.v * b.v); }
  friend Lanes operator/(const Lanes& a, const Lanes& b) { return Lanes(a.v / b.v); }
  friend Lanes operator-(const Lanes& a) { return Lanes(-a.v); }
};

template <int W>
void add_product(Lanes<W>& acc, const Lanes<W>& a, const Lanes<W>& b) {
  acc.v += a.v * b.v;
}
template <int W>
Lanes<W> abs(const Lanes<W>& a) {
  return Lanes<W>(a.v < 0 ? -a.v : a.v);
}
template <int W>
Lanes<W> max(const Lanes<W>& a, const Lanes<W>& b) {
  return Lanes<W>(a.v > b.v ? a.v : b.v);
}
template <int W>
Lanes<W> min(const Lanes<W>& a, const Lanes<W>& b) {
  return Lanes<W>(a.v < b.v ? a.v : b.v);
}

template <int W>
[[gnu::always_inline]] inline Lanes<W> square_root(Lanes<W> x) {
#ifdef __AVX512F__
  if constexpr (W == 8) return Lanes<W>(reinterpret_cast<typename Lanes<W>::Vec>(_mm512_maskz_sqrt_pd(0xff, x.v)));
#endif
#ifdef __AVX2__
  if constexpr (W == 4) return Lanes<W>(reinterpret_cast<typename Lanes<W>::Vec>(_mm256_sqrt_pd(x.v)));
#endif
  for (int i = 0; i < W; ++i) x.set(i, std::sqrt(x[i]));
  return x;
}

// Bit i of the result: is lane i of a comparison true?
template <int W>
[[gnu::always_inline]] inline unsigned mask_of(const typename Register<W>::Bits& x) {
#ifdef __AVX512DQ__
  if constexpr (W == 8) return _mm512_movepi64_mask(reinterpret_cast<__m512i>(x));
#endif
#ifdef __AVX2__
  if constexpr (W == 4) return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(x)));
#endif
  if constexpr (W > 4) {
    constexpr int half = W / 2;
    typename Register<half>::Bits part[2];
    static_assert(sizeof part == sizeof x);
    __builtin_memcpy(part, &x, sizeof x);
    return mask_of<half>(part[0]) | mask_of<half>(part[1]) << half;
  }
  unsigned mask = 0;
  for (int i = 0; i < W; ++i) mask |= static_cast<unsigned>(x[i] & 1) << i;
  return mask;
}

}  // namespace stickslip::inline STICKSLIP_ISA
