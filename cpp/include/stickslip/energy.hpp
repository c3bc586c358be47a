// Can the energy of W w'' + C w' + K w = 0 only fall?
#pragma once

#include "stickslip/bodies/dense.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr double energy_rounding = 1e-12;  // of a matrix, by which it may miss being symmetric or positive

// Is a + slack I positive definite, by Cholesky? `a` (m x m, destroyed) is symmetric.
template <class R>
bool is_positive(R* a, int m, const R& slack) {
  for (int k = 0; k < m; ++k) {
    const R pivot = a[k * m + k] + slack;
    if (!(pivot > 0)) return false;
    for (int i = k + 1; i < m; ++i)
      for (int j = k + 1; j < m; ++j) a[i * m + j] -= a[i * m + k] * a[k * m + j] / pivot;
  }
  return true;
}

// Puts the symmetric part of `from` into `to`; false if `from` has another part beyond rounding.
template <class R>
bool symmetric_part(const R* from, int m, R* to, R& size) {
  size = R(0.0);
  R other(0.0);
  for (int i = 0; i < m * m; ++i) {
    const R one = from[i], turned = from[i % m * m + i / m];
    to[i] = (one + turned) * 0.5;
    size = largest(size, R(magnitude(one)));
    other = largest(other, R(magnitude(R(one - turned))));
  }
  return other <= size * energy_rounding;
}

// Can the energy only fall?
template <class R>
bool energy_falls(const R* W, const R* C, const R* K, int m, R* room) {
  R size(0.0);
  symmetric_part(C, m, room, size);
  if (!is_positive(room, m, R(size * energy_rounding + 1e-300))) return false;
  for (const R* one : {W, K})
    if (!symmetric_part(one, m, room, size) || !is_positive(room, m, R(0.0))) return false;
  return true;
}

}  // namespace stickslip::inline STICKSLIP_ISA
