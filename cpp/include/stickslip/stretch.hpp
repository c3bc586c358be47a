// A long stretch of a linear mode, crossed at once.
//
//   y'' = Q y + R y' + f0 + f1 t + f2 t^2
// moves as a polynomial p(t) and a rest w(t) with w'' = Q w + R w'. The energy (w' W w' + w K w)/2 of
// W w'' + C w' + K w = 0 only falls where the symmetric part of C is not negative; by Cauchy and Schwarz it bounds what w
// can still do to a switching function, so that nothing is crossed before p alone comes within that bound of it.
#pragma once

#include "stickslip/energy.hpp"
#include "stickslip/system.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr long patience = 64;       // steps of one linear mode before the rest of it is tried at once: 20 turns
constexpr double worth_it = 32.0;   // steps: a shorter stretch costs less step by step
constexpr double last_steps = 4.0;  // before a surface or a time that is asked for: more than a turn of what swings

// Numbers of a stretch of m coordinates, in memory of the owner's.
template <class T>
struct Stretch {
  int m = 0;
  T *Q = nullptr, *R = nullptr;                     // m x m
  T *f = nullptr, *p = nullptr;                     // 3 x m: by powers of t
  T* w = nullptr;                                   // 2 m: first y and y', then w and w'
  T* room = nullptr;                                // 12 m x m
  Real<T>*W = nullptr, *C = nullptr, *K = nullptr;  // m x m; K and W are inverted on the way
  Real<T>* real_room = nullptr;                     // 2 m x m
  Real<T> energy{};
};

// The polynomial that solves the equation, and w beside it; false where there is none of degree 2 (Q is singular).
template <class T>
bool split(Stretch<T>& s) {
  const int m = s.m;
  T *inverse = s.room, *a = s.room + m * m, *right = s.room + 2 * m * m;
  for (int i = 0; i < m * m; ++i) a[i] = s.Q[i];
  invert(a, inverse, m);
  for (int k = 2; k >= 0; --k) {  // Q p_k = (k + 1) (k + 2) p_(k+2) - f_k - (k + 1) R p_(k+1)
    for (int i = 0; i < m; ++i) {
      right[i] = -s.f[k * m + i];
      if (k == 0) right[i] = right[i] + s.p[2 * m + i] * 2.0;
      if (k < 2) right[i] = right[i] - dot(s.R + i * m, s.p + (k + 1) * m, m) * static_cast<double>(k + 1);
    }
    multiply(inverse, right, m, m, 1, s.p + k * m);
  }
  Real<T> sum(0.0);
  for (int i = 0; i < m; ++i) {
    s.w[i] = s.w[i] - s.p[i];
    s.w[m + i] = s.w[m + i] - s.p[m + i];
    sum += value(s.w[i]) + value(s.w[m + i]) + value(s.p[2 * m + i]);
  }
  if (!std::isfinite(sum)) return false;
  if (!energy_falls(s.W, s.C, s.K, m, s.real_room)) return false;
  s.energy = Real<T>(0.0);
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < m; ++j)
      s.energy +=
          s.K[i * m + j] * value(s.w[i]) * value(s.w[j]) + s.W[i * m + j] * value(s.w[m + i]) * value(s.w[m + j]);
  for (Real<T>* one : {s.K, s.W}) {
    for (int i = 0; i < m * m; ++i) s.real_room[i] = one[i];
    invert(s.real_room, one, m);
  }
  return true;
}

// A bound on |row . (w, w')| from now on.
template <class T>
Real<T> reach_of(const Stretch<T>& s, const Real<T>* row) {
  using R = Real<T>;
  R size(0.0);
  for (const R* inverse : {s.K, s.W}) {
    for (int i = 0; i < s.m; ++i)
      for (int j = 0; j < s.m; ++j) size += row[i] * inverse[i * s.m + j] * row[j];
    row += s.m;
  }
  return square_root(R(largest(R(size * s.energy), R(0.0))));
}

// How long c0 + c1 t + c2 t^2 stays above 0, at most `most`.
template <class R>
R stays_above(const R& c0, const R& c1, const R& c2, const R& most) {
  if (!(c0 > 0)) return R(0.0);
  const R inside = c1 * c1 - c0 * c2 * 4.0;
  if (inside < 0) return most;
  const R down = square_root(inside) - c1;  // the smaller positive root is 2 c0 / (root - c1)
  return down > 0 ? smallest(most, R(c0 * 2.0 / down)) : most;
}

// w and w' at h. One coordinate that swings: in closed form. Else the flow over h by halving and squaring.
template <class T>
void flow(const Stretch<T>& s, const Real<T>& h, const Real<T>& unit) {
  using R = Real<T>;
  const int m = s.m, n = 2 * m;
  if (m == 1) {
    const T decay = s.R[0] * 0.5, square = -s.Q[0] - decay * decay;
    if (value(square) > value(decay) * value(decay) * 1e-3) {
      const T turn = square_root(square), by = exponential(decay * h), c = cosine(turn * h) * by,
              r = sine(turn * h) * by / turn, w = s.w[0], v = s.w[1];
      s.w[0] = c * w + r * (v - decay * w);
      s.w[1] = c * v + r * (s.Q[0] * w + decay * v);
      return;
    }
  }
  int halvings = 0;
  R step = h;
  for (; step > unit; ++halvings) step *= 0.5;
  T *A = s.room, *power = A + n * n, *next = power + n * n;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      A[i * n + j] = i < m ? T(j == i + m ? 1.0 : 0.0) : (j < m ? s.Q[(i - m) * m + j] : s.R[(i - m) * m + j - m]);
      power[i * n + j] = T(i == j ? 1.0 : 0.0);
    }
  for (int k = linear_order; k >= 1; --k) {  // Horner: 1 + A h/1 (1 + A h/2 (...))
    multiply(A, power, n, n, n, next);
    for (int i = 0; i < n * n; ++i) power[i] = next[i] * (step * inverse<T>(k)) + (i % (n + 1) == 0 ? 1.0 : 0.0);
  }
  for (; halvings > 0; --halvings) {
    multiply(power, power, n, n, n, next);
    std::swap(power, next);
  }
  multiply(power, s.w, n, n, 1, A);
  for (int i = 0; i < n; ++i) s.w[i] = A[i];
}

// Coordinate i and its speed at h, after `flow` over the value of h.
template <class T>
T place_at(const Stretch<T>& s, int i, const T& h) {
  return s.p[i] + h * (s.p[s.m + i] + h * s.p[2 * s.m + i]) + s.w[i];
}
template <class T>
T speed_at(const Stretch<T>& s, int i, const T& h) {
  return s.p[s.m + i] + h * s.p[2 * s.m + i] * 2.0 + s.w[s.m + i];
}

}  // namespace stickslip::inline STICKSLIP_ISA
