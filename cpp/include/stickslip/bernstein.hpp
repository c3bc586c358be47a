// Polynomials on [0, 1] by their Bernstein coefficients, which bound them and whose sign changes count their roots.
#pragma once

#include "stickslip/series.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Pascal's triangle by columns, each with room to be read in fours, and its reciprocals by rows.
struct Binomials {
  static constexpr int room = (max_order / 4 + 1) * 4;
  double column[max_order + 1][room], over[max_order + 1][max_order + 1];  // [k][i]: C(i, k); [n][k]: 1/C(n, k)
  constexpr Binomials() : column{}, over{} {
    for (int i = 0; i < room; ++i)
      for (int k = 0; k <= i && k <= max_order; ++k)
        column[k][i] = k == 0 ? 1.0 : (k < i ? column[k - 1][i - 1] + column[k][i - 1] : 1.0);
    for (int n = 0; n <= max_order; ++n)
      for (int k = 0; k <= n; ++k) over[n][k] = 1.0 / column[k][n];
  }
};
inline constexpr Binomials binomials{};

// Bernstein coefficients on [0, 1] of sum a_k x^k: b_i = sum over k <= i of C(i, k)/C(n, k) a_k. `b` has room for fours.
template <class R>
void to_bernstein(const R* a, int n, R* b) {
  if constexpr (std::is_same_v<R, double>) {  // a product with a matrix, four rows at once: no sum waits for another
    double scaled[series_size];
    for (int k = 0; k <= n; ++k) scaled[k] = a[k] * binomials.over[n][k];
    for (int i = 0; i <= n; i += 4) {
      Lanes<4> even(0.0), odd(0.0);
      const int last = i + 3 < n ? i + 3 : n;
      const auto add = [&](Lanes<4>& sum, int k) {
        Lanes<4> rows;
        __builtin_memcpy(&rows, &binomials.column[k][i], sizeof rows);
        sum.v += scaled[k] * rows.v;
      };
      int k = 0;
      for (; k < last; k += 2) {
        add(even, k);
        add(odd, k + 1);
      }
      if (k == last) add(even, k);
      even += odd;
      __builtin_memcpy(b + i, &even, sizeof even);
    }
  } else {
    for (int k = 0; k <= n; ++k) b[k] = a[k] * binomials.over[n][k];
    for (int i = 1; i <= n; ++i)
      for (int j = n; j >= i; --j) b[j] = b[j] + b[j - 1];
  }
}

// The coefficients on the two halves (de Casteljau); the left half replaces b.
template <class R>
void halve(R* b, int n, R* right) {
  for (int i = 0; i <= n; ++i) {
    right[n - i] = b[n];
    for (int j = n; j > i; --j) b[j] = (b[j] + b[j - 1]) * 0.5;
  }
}

struct Bracket {
  bool found = false;
  double a = 0, b = 0;  // S(a) > 0 > S(b), one root between; as fractions of the step
};

// First root of a polynomial given by its Bernstein coefficients on [a, a + width]; positive at a.
template <class R>
Bracket first_sign_change(R* b, int n, double a, double width, R noise, int depth) {
  int changes = 0;
  bool positive = true, below = false;
  for (int k = 0; k <= n; ++k) {
    if (b[k] < -noise) below = true;
    const bool p = b[k] > 0 || (k < n && b[k] >= -noise && positive);
    if (p != positive) ++changes;
    positive = p;
  }
  if (!below) return {};
  if (changes == 1 || depth == 0) return {b[n] < 0, a, a + width};
  R right[series_size];
  halve(b, n, right);
  const Bracket left = first_sign_change(b, n, a, 0.5 * width, noise, depth - 1);
  return left.found ? left : first_sign_change(right, n, a + 0.5 * width, 0.5 * width, noise, depth - 1);
}

}  // namespace stickslip::inline STICKSLIP_ISA
