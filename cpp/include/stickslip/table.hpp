// The tabulated term: a natural cubic spline through its values at the knots, constant outside them; with a period, the
// periodic spline.
#pragma once

#include <cmath>
#include <numbers>

#include "stickslip/piece.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Jump of the slope at the middle of three knots, six times: the right-hand side of the spline's equations.
template <class T>
T bend(double left, double right, const T& before, const T& here, const T& after) {
  return ((after - here) / right - (here - before) / left) * 6.0;
}

template <class T>
void natural_curvature(const double* knot, const T* y, int n, T* m) {
  T d[max_knots];
  double c[max_knots];
  m[0] = d[0] = T(0.0);
  c[0] = 0;
  for (int i = 1; i < n - 1; ++i) {
    const double left = knot[i] - knot[i - 1], right = knot[i + 1] - knot[i];
    const double pivot = 2 * (left + right) - left * c[i - 1];
    c[i] = right / pivot;
    d[i] = (bend(left, right, y[i - 1], y[i], y[i + 1]) - d[i - 1] * left) / pivot;
  }
  m[n - 1] = T(0.0);
  for (int i = n - 2; i > 0; --i) m[i] = d[i] - m[i + 1] * c[i];
}

// The last knot is the first again. The matrix is real and diagonally dominant: elimination without pivoting.
template <class T>
void periodic_curvature(const double* knot, const T* y, int n, T* m) {
  const int size = n - 1;
  double a[max_knots][max_knots] = {};
  for (int i = 0; i < size; ++i) {
    const int before = (i + size - 1) % size, after = (i + 1) % size;
    const double left = knot[before + 1] - knot[before], right = knot[i + 1] - knot[i];
    a[i][i] += 2 * (left + right);
    a[i][before] += left;
    a[i][after] += right;
    m[i] = bend(left, right, y[before], y[i], y[i + 1]);
  }
  for (int k = 0; k < size; ++k)
    for (int i = k + 1; i < size; ++i) {
      const double factor = a[i][k] / a[k][k];
      for (int j = k; j < size; ++j) a[i][j] -= factor * a[k][j];
      m[i] = m[i] - m[k] * factor;
    }
  for (int k = size - 1; k >= 0; --k) {
    for (int j = k + 1; j < size; ++j) m[k] = m[k] - m[j] * a[k][j];
    m[k] = m[k] / a[k][k];
  }
  m[size] = m[0];
}

// Interval i > 0 starts at knot i - 1; 0 and the last hold the end values. The tridiagonal system for the second
// derivatives has real coefficients, so values may carry derivatives.
template <class E, class T>
void build_table(System<T>& sys) {
  const Table& own = sys.structure.table[E::table];
  const int n = own.knots;
  if (n < 2) return;
  const T* y = sys.p.p + slot_count + E::table * max_knots;
  T m[max_knots];  // second derivatives
  if (own.period > 0) {
    T& phi = sys.p[first_slot<E> + place_of(E::parameters, "phi")];  // whole turns off: a side counts periods in an int
    const double turn = 2 * std::numbers::pi;
    phi = phi - turn * std::floor(static_cast<double>(value(phi)) / turn);
    periodic_curvature(own.knot, y, n, m);
  } else {
    natural_curvature(own.knot, y, n, m);
  }
  auto& table = sys.table[E::table];
  for (T& flat : table[0]) flat = T(0.0);
  for (T& flat : table[n]) flat = T(0.0);
  table[0][0] = y[0];
  table[n][0] = y[n - 1];
  for (int i = 0; i + 1 < n; ++i) {
    const double h = own.knot[i + 1] - own.knot[i];
    T* out = table[i + 1];
    out[0] = y[i];
    out[1] = (y[i + 1] - y[i]) / h - (m[i] * 2.0 + m[i + 1]) * (h / 6);
    out[2] = m[i] * 0.5;
    out[3] = (m[i + 1] - m[i]) / (6 * h);
  }
}
template <class T>
void build_tables(System<T>& sys) {
  build_table<Tabulated>(sys);
  build_table<SecondTabulated>(sys);
}

}  // namespace stickslip::inline STICKSLIP_ISA
