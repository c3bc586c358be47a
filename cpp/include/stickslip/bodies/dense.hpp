// Small dense matrices, row by row, in every number type.
#pragma once

#include "stickslip/numbers.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// The inverse of `a` (n x n, destroyed) by Gauss and Jordan with the largest pivot of each column; of a singular matrix
// it is not finite.
template <class T>
void invert(T* a, T* out, int n) {
  for (int i = 0; i < n * n; ++i) out[i] = T(i % (n + 1) == 0 ? 1.0 : 0.0);
  for (int k = 0; k < n; ++k) {
    int pivot = k;
    for (int i = k + 1; i < n; ++i)
      if (magnitude(value(a[i * n + k])) > magnitude(value(a[pivot * n + k]))) pivot = i;
    for (int j = 0; j < n && pivot != k; ++j) {
      std::swap(a[k * n + j], a[pivot * n + j]);
      std::swap(out[k * n + j], out[pivot * n + j]);
    }
    const T over = T(1.0) / a[k * n + k];
    for (int j = 0; j < n; ++j) {
      a[k * n + j] = a[k * n + j] * over;
      out[k * n + j] = out[k * n + j] * over;
    }
    for (int i = 0; i < n; ++i) {
      if (i == k) continue;
      const T factor = -a[i * n + k];
      for (int j = 0; j < n; ++j) {
        add_product(a[i * n + j], factor, a[k * n + j]);
        add_product(out[i * n + j], factor, out[k * n + j]);
      }
    }
  }
}

// out (rows x columns) = a (rows x inner) b (inner x columns)
template <class T>
void multiply(const T* a, const T* b, int rows, int inner, int columns, T* out) {
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      T s(0.0);
      for (int k = 0; k < inner; ++k) add_product(s, a[i * inner + k], b[k * columns + j]);
      out[i * columns + j] = s;
    }
}

template <class T>
T dot(const T* a, const T* b, int n) {
  T s(0.0);
  for (int i = 0; i < n; ++i) add_product(s, a[i], b[i]);
  return s;
}

// A bound on the size of the eigenvalues of a (n x n): the least of its norms by rows, by columns and by all entries,
// coordinates scaled by `weight`.
template <class T>
Real<T> eigenvalue_bound(const T* a, const Real<T>* weight, int n) {
  using R = Real<T>;
  R rows(0.0), columns(0.0), all(0.0);
  for (int i = 0; i < n; ++i) {
    R row(0.0), column(0.0);
    for (int j = 0; j < n; ++j) {
      const R one = magnitude(value(a[i * n + j])) * weight[i] / weight[j];
      row += one;
      all += one * one;
      column += magnitude(value(a[j * n + i])) * weight[j] / weight[i];
    }
    rows = largest(rows, row);
    columns = largest(columns, column);
  }
  return smallest(smallest(rows, columns), R(square_root(all)));
}

}  // namespace stickslip::inline STICKSLIP_ISA
