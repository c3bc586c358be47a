// exp, and rough log2 and 2^x: the same polynomials in every width, the scalar one included, so that a lane agrees with the
// scalar kernel to rounding.
#pragma once

#include "stickslip/lanes.hpp"

namespace stickslip::inline STICKSLIP_ISA {

namespace detail {
// e^x by Cody-Waite reduction and a degree-13 Taylor polynomial on |r| <= ln2/2: error below 1 unit in the last
// place. V is a double or a vector of them, B its bits.
template <class V, class B>
V exp_poly(V x) {
  const V lo = x - x - 708.0, hi = x - x + 708.0;
  x = x < lo ? lo : (x > hi ? hi : x);
  constexpr double magic = 0x1.8p52;
  V n = x * 1.4426950408889634074 + magic;
  B k;
  if constexpr (sizeof(V) == sizeof(double)) {
    k = std::bit_cast<B>(n);
  } else {
    k = reinterpret_cast<B>(n);
  }
  n = n - magic;
  const V r = (x - n * 6.93147180369123816490e-01) - n * 1.90821492927058770002e-10;
  const V r2 = r * r, r4 = r2 * r2;  // Estrin: short chains
  const V p01 = r * (1.0 / 6) + 0.5, p23 = r * (1.0 / 120) + 1.0 / 24, p45 = r * (1.0 / 5040) + 1.0 / 720;
  const V p67 = r * (1.0 / 362880) + 1.0 / 40320, p89 = r * (1.0 / 39916800) + 1.0 / 3628800;
  const V pab = r * (1.0 / 6227020800) + 1.0 / 479001600;
  const V low = p23 * r2 + p01, mid = p67 * r2 + p45, high = pab * r2 + p89;
  const V p = ((high * r4 + mid) * r4 + low) * r2 + r + 1.0;
  const B scale = (k + 1023) << 52;
  if constexpr (sizeof(V) == sizeof(double)) {
    return p * std::bit_cast<V>(scale);
  } else {
    return p * reinterpret_cast<V>(scale);
  }
}

// log2(x) to 3e-5, for step-size control alone; x > 0 and normal.
template <class V, class B>
V log2_rough(V x) {
  B k;
  if constexpr (sizeof(V) == sizeof(double)) {
    k = std::bit_cast<B>(x);
  } else {
    k = reinterpret_cast<B>(x);
  }
  // the exponent becomes a double by its bits: not every instruction set converts vectors of integers
  constexpr double offset = 0x1p52;
  const B e = ((k >> 32) & 0x7ff00000) >> 20 | std::bit_cast<std::int64_t>(offset);
  const B m = (k & 0x000fffffffffffff) | 0x3ff0000000000000;
  V f, ev;
  if constexpr (sizeof(V) == sizeof(double)) {
    f = std::bit_cast<V>(m);
    ev = std::bit_cast<V>(e);
  } else {
    f = reinterpret_cast<V>(m);
    ev = reinterpret_cast<V>(e);
  }
  ev = ev - (offset + 1023.0);
  const V g = f - 1.0, g2 = g * g;  // a fit on [1, 2), exact at its ends
  return ev + (1.44174030288 * g - 0.70777018 * g2) + g2 * (0.41234422 * g + g2 * (0.04400469 * g - 0.19031903));
}
// 2^x to 1e-4, likewise.
template <class V, class B>
V exp2_rough(V x) {
  const V lo = x - x - 1000.0, hi = x - x + 1000.0;
  x = x < lo ? lo : (x > hi ? hi : x);
  constexpr double magic = 0x1.8p52;
  const V n = x + magic, r = x - (n - magic);  // |r| <= 1/2
  const V r2 = r * r, p = (1.0 + 0.693147 * r) + r2 * ((0.240227 + 0.0557 * r) + 0.0096 * r2);
  if constexpr (sizeof(V) == sizeof(double)) {
    return p * std::bit_cast<V>((std::bit_cast<B>(n) + 1023) << 52);
  } else {
    return p * reinterpret_cast<V>((reinterpret_cast<B>(n) + 1023) << 52);
  }
}
}  // namespace detail

}  // namespace stickslip::inline STICKSLIP_ISA
