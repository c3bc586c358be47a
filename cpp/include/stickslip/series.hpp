// Truncated Taylor series of a trajectory and the recurrences that build them, order by order (automatic
// differentiation in time; Jorba and Zou 2005). Coefficient k is that of (t - t0)^k.
#pragma once

#include "stickslip/lanewise.hpp"
#include "stickslip/pair.hpp"

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

// sum of a_j b_{k-j} over j = from..to in two accumulators, so that additions do not wait for each other.
template <class T, class U>
[[gnu::always_inline]] inline U partial_product(const T* a, const U* b, int k, int from, int to) {
  U s0(0.0), s1(0.0);
  int j = from;
  for (; j < to; j += 2) {
    add_product(s0, a[j], b[k - j]);
    add_product(s1, a[j + 1], b[k - j - 1]);
  }
  if (j == to) add_product(s0, a[j], b[k - j]);
  return s0 + s1;
}

// Coefficient k of a b. The newest coefficients enter last: they are what the processor waits for.
template <class T>
T product(const T* a, const T* b, int k) {
  if (k == 0) return a[0] * b[0];
  T s = partial_product(a, b, k, 1, k - 1);
  add_product(s, a[k], b[0]);
  add_product(s, a[0], b[k]);
  return s;
}

// e^a: k e_k = sum_{j=1..k} slope_j e_{k-j} with slope_j = j a_j. This is the sum without its last term, for k >= 2.
template <class T, class U>
[[gnu::always_inline]] inline U exponential_rest(const T* slope, const U* e, int k) {
  U s = partial_product(slope, e, k, 2, k - 1);
  add_product(s, slope[1], e[k - 1]);
  return s;
}

// Coefficient k >= 1 of e^a from slope[1..k] and the coefficients before it.
template <class T>
T exponential_next(const T* slope, const T* e, int k) {
  T s = slope[k] * e[0];
  if (k > 1) s = s + exponential_rest(slope, e, k);
  return s * inverse<T>(k);
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

// The same for four series in step, in even and odd powers: short chains that do not wait for each other. order >= 2.
template <class T>
void evaluate_four(const T* const (&c)[4], int order, const T& h, T* out) {
  const T square = h * h;
  const int top = order - 1 + order % 2;  // the highest odd power
  T even[4], odd[4];
  for (int i = 0; i < 4; ++i) {
    odd[i] = c[i][top];
    even[i] = c[i][top - 1];
  }
  if (top != order)
    for (int i = 0; i < 4; ++i) even[i] = even[i] + c[i][order] * square;
  for (int k = top - 2; k > 0; k -= 2) {
    for (int i = 0; i < 4; ++i) {
      odd[i] = odd[i] * square + c[i][k];
      even[i] = even[i] * square + c[i][k - 1];
    }
  }
  for (int i = 0; i < 4; ++i) out[i] = even[i] + odd[i] * h;
}

// Its first derivative.
template <class T, class H>
T evaluate_slope(const T* c, int order, const H& h) {
  T s = c[order] * static_cast<double>(order);
  for (int k = order - 1; k >= 1; --k) s = s * h + c[k] * static_cast<double>(k);
  return s;
}

}  // namespace stickslip::inline STICKSLIP_ISA
