// Recurrences of the functions that only formulas use (series.hpp has the others).
#pragma once

#include <cmath>

#include "stickslip/bodies/link.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// sum over j = 1..k of j a_j b_(k-j), with slope[j] = j a_j kept along.
template <class T>
T slope_product(T* slope, const T* a, const T* b, int k) {
  slope[k] = a[k] * static_cast<double>(k);
  return rotation_next(slope, b, k);
}

// Does a power start at 0? A base that has landed there is 0 but for rounding; u at the onset of slip is 0 exactly.
template <class T>
bool of_zero(const Instruction<T>& in) {
  return magnitude(value(in.a[0])) <= value(in.aux[largest_base]) * value(in.y);
}

// a^x, x no whole number. Where a starts at 0 there is no series: what stands for it was put beside it (onset.hpp).
template <class T>
T power_next(const Instruction<T>& in, int k) {
  if (k == 0)
    in.aux[largest_base] = T(largest(Real<T>(magnitude(value(in.a[0]))), Real<T>(value(in.aux[largest_base]))));
  if (of_zero(in)) return in.aux[1 + k];
  if (k == 0) {
    in.aux[0] = T(1.0) / in.a[0];
    return raised(in.a[0], in.x);
  }
  T plain(0.0), sloped(0.0);
  for (int j = 1; j <= k; ++j) {
    const T one = in.a[j] * in.c[k - j];
    plain += one;
    sloped += one * static_cast<double>(j);
  }
  return ((in.x + T(1.0)) * sloped * inverse<T>(k) - plain) * in.aux[0];
}

template <class T>
T whole_power_next(const Instruction<T>& in, int k) {
  const T *square = in.a, *so_far = nullptr;
  T* room = in.aux;
  int p = static_cast<int>(std::lround(static_cast<double>(value(in.x))));
  for (;;) {
    if (p % 2 == 1) {
      if (so_far == nullptr) {
        so_far = square;
      } else {
        room[k] = product(so_far, square, k);
        so_far = room;
        room += series_size;
      }
    }
    p /= 2;
    if (p == 0) return so_far[k];
    room[k] = product(square, square, k);
    square = room;
    room += series_size;
  }
}

template <class T>
T exponential_of(T* slope, const T* c, const T& argument, int k) {
  if (k == 0) return exponential(argument);
  slope[k] = argument * static_cast<double>(k);
  return exponential_next(slope, c, k);
}

template <class T>
T logarithm_next(const T* a, const T* c, T& over, int k) {
  if (k == 0) {
    over = T(1.0) / a[0];
    return logarithm(a[0]);
  }
  T s(0.0);
  for (int j = 1; j < k; ++j) add_product(s, c[j] * static_cast<double>(j), a[k - j]);
  return (a[k] - s * inverse<T>(k)) * over;
}

template <class T>
T asinh_next(const Instruction<T>& in, int k) {
  T *slope = in.aux, *root = in.aux + series_size,
    *square = in.aux + 2 * series_size;  // of y' root = a', root^2 = 1 + a^2
  square[k] = product(in.a, in.a, k);
  if (k == 0) {
    square[0] = square[0] + 1.0;
    root[0] = square_root(square[0]);
    return area_sine(in.a[0]);
  }
  const T over = T(1.0) / root[0];
  T s(0.0);
  for (int j = 1; j < k; ++j) add_product(s, root[j], root[k - j]);
  root[k] = (square[k] - s) * over * 0.5;
  T sum(0.0);
  for (int j = 1; j < k; ++j) add_product(sum, slope[j], root[k - j]);
  slope[k] = (in.a[k] * static_cast<double>(k) - sum) * over;
  return slope[k] * inverse<T>(k);
}

}  // namespace stickslip::inline STICKSLIP_ISA
