// Truncated Taylor series of a trajectory and the recurrences that build them, order by order (automatic
// differentiation in time; Jorba and Zou 2005). Coefficient k is that of (t - t0)^k.
#pragma once

#include "stickslip/numbers.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr int max_order = 30;
constexpr int series_size = max_order + 2;

// 1/k without a division in the inner loops.
struct Reciprocals {
  double r[series_size + 1];
  constexpr Reciprocals() : r{} {
    for (int k = 1; k <= series_size; ++k) r[k] = 1.0 / k;
  }
};
inline constexpr Reciprocals reciprocals{};
template <class T>
constexpr Real<T> inverse(int k) {
  if constexpr (std::is_same_v<T, long double>) {
    return 1.0L / k;
  } else {
    return Real<T>(reciprocals.r[k]);
  }
}

// Coefficient k of a b.
template <class T>
T product(const T* a, const T* b, int k) {
  T s0 = a[0] * b[k], s1(0.0);
  int j = 1;
  for (; j < k; j += 2) {  // two sums, so that the additions do not wait for each other
    add_product(s0, a[j], b[k - j]);
    add_product(s1, a[j + 1], b[k - j - 1]);
  }
  if (j == k) add_product(s0, a[j], b[0]);
  return s0 + s1;
}

// Coefficient k >= 1 of e^a, given slope[j] = j a_j for j = 1..k and the coefficients 0..k-1 of e^a.
template <class T>
T exponential_next(const T* slope, const T* e, int k) {
  T s0 = slope[1] * e[k - 1], s1(0.0);
  int j = 2;
  for (; j < k; j += 2) {
    add_product(s0, slope[j], e[k - j]);
    add_product(s1, slope[j + 1], e[k - j - 1]);
  }
  if (j == k) add_product(s0, slope[j], e[0]);
  return (s0 + s1) * inverse<T>(k);
}

// Coefficient k of num/den: (num_k - sum_{j=1..k} den_j q_{k-j}) / den_0, with `over` = 1/den_0.
template <class T>
T quotient_next(const T& num, const T* den, const T* q, const T& over, int k) {
  T s(0.0);
  for (int j = 1; j <= k; ++j) add_product(s, den[j], q[k - j]);
  return (num - s) * over;
}

// Coefficient k >= 1 of sin a (given cos a) and of cos a (with -sin a): the same sum.
template <class T>
T rotation_next(const T* slope, const T* partner, int k) {
  T s(0.0);
  for (int j = 1; j <= k; ++j) add_product(s, slope[j], partner[k - j]);
  return s * inverse<T>(k);
}

// Value of a series of the given order at h (Horner).
template <class T, class H>
T evaluate(const T* c, int order, const H& h) {
  T s = c[order];
  for (int k = order - 1; k >= 0; --k) s = s * h + c[k];
  return s;
}

// Its first derivative.
template <class T, class H>
T evaluate_slope(const T* c, int order, const H& h) {
  T s = c[order] * static_cast<double>(order);
  for (int k = order - 1; k >= 1; --k) s = s * h + c[k] * static_cast<double>(k);
  return s;
}

}  // namespace stickslip::inline STICKSLIP_ISA
