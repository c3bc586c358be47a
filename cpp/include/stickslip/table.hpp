// The tabulated term: a natural cubic spline through its values at the knots, constant outside them.
#pragma once

#include "stickslip/piece.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Interval i > 0 starts at knot i - 1; 0 and the last hold the end values. The tridiagonal system for the second
// derivatives has real coefficients, so values may carry derivatives.
template <class T>
void build_table(System<T>& sys) {
  const Structure& st = sys.structure;
  const int n = st.knots;
  if (n < 2) return;
  const T* y = sys.p.p + slot_count;
  T m[max_knots], d[max_knots];  // second derivatives; right-hand sides
  double c[max_knots];
  m[0] = d[0] = T(0.0);
  c[0] = 0;
  for (int i = 1; i < n - 1; ++i) {
    const double left = st.knot[i] - st.knot[i - 1], right = st.knot[i + 1] - st.knot[i];
    const double pivot = 2 * (left + right) - left * c[i - 1];
    c[i] = right / pivot;
    d[i] = (((y[i + 1] - y[i]) / right - (y[i] - y[i - 1]) / left) * 6.0 - d[i - 1] * left) / pivot;
  }
  m[n - 1] = T(0.0);
  for (int i = n - 2; i > 0; --i) m[i] = d[i] - m[i + 1] * c[i];
  for (T& flat : sys.table[0]) flat = T(0.0);
  for (T& flat : sys.table[n]) flat = T(0.0);
  sys.table[0][0] = y[0];
  sys.table[n][0] = y[n - 1];
  for (int i = 0; i + 1 < n; ++i) {
    const double h = st.knot[i + 1] - st.knot[i];
    T* out = sys.table[i + 1];
    out[0] = y[i];
    out[1] = (y[i + 1] - y[i]) / h - (m[i] * 2.0 + m[i + 1]) * (h / 6);
    out[2] = m[i] * 0.5;
    out[3] = (m[i + 1] - m[i]) / (6 * h);
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
