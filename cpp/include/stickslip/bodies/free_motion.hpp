// What is left to move beside what sticks, where the present modes are linear, as the equation of a stretch.
//
// With contacts held, q = X s(t) + N y: X = M^-1 D' G^-1 moves with what sticks, s = D q, and the columns of N span what is
// left, each with one coordinate of its own.
#pragma once

#include "stickslip/bodies/look.hpp"
#include "stickslip/stretch.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
struct BodiesStretch {
  Stretch<T> s;
  T *N = nullptr, *reduced = nullptr, *held = nullptr, *path = nullptr;  // n x m, contacts x n, 3 x contacts, 3 x n
  Real<T>* row = nullptr;
  int *own = nullptr, *pivot = nullptr;  // the coordinate of each column of N; of each held contact

  void place(Arena& arena, int n, int contacts) {
    for (T** one : {&s.Q, &s.R, &N}) *one = arena.take<T>(n * n);
    for (T** one : {&s.f, &s.p, &path}) *one = arena.take<T>(3 * n);
    s.w = arena.take<T>(2 * n);
    s.room = arena.take<T>(12 * n * n);
    for (Real<T>** one : {&s.W, &s.C, &s.K}) *one = arena.take<Real<T>>(n * n);
    s.real_room = arena.take<Real<T>>(2 * n * n);
    reduced = arena.take<T>(contacts * n);
    held = arena.take<T>(3 * contacts);
    row = arena.take<Real<T>>(2 * n);
    own = arena.take<int>(n);
    pivot = arena.take<int>(contacts);
  }
};

// N, by Gauss and Jordan on the rows of the held contacts.
template <class T>
void span_free(const BodiesSystem<T>& sys, BodiesStretch<T>& b) {
  const int n = sys.n, m = b.s.m = n - sys.stuck_count;
  const auto taken = [&](int c, int rows) {
    for (int a = 0; a < rows; ++a)
      if (b.pivot[a] == c) return true;
    return false;
  };
  for (int a = 0; a < sys.stuck_count; ++a)
    for (int c = 0; c < n; ++c) b.reduced[a * n + c] = sys.D(sys.stuck[a])[c];
  for (int a = 0; a < sys.stuck_count; ++a) {
    T* row = b.reduced + a * n;
    int best = -1;
    for (int c = 0; c < n; ++c)
      if (!taken(c, a) && (best < 0 || magnitude(value(row[c])) > magnitude(value(row[best])))) best = c;
    b.pivot[a] = best;
    const T over = T(1.0) / row[best];
    for (int c = 0; c < n; ++c) row[c] = row[c] * over;
    for (int other = 0; other < sys.stuck_count; ++other) {
      const T by = -b.reduced[other * n + best];
      for (int c = 0; other != a && c < n; ++c) add_product(b.reduced[other * n + c], by, row[c]);
    }
  }
  for (int i = 0; i < n * m; ++i) b.N[i] = T(0.0);
  for (int c = 0, j = 0; c < n; ++c) {
    if (taken(c, sys.stuck_count)) continue;
    b.own[j] = c;
    b.N[c * m + j] = T(1.0);
    for (int a = 0; a < sys.stuck_count; ++a) b.N[b.pivot[a] * m + j] = -b.reduced[a * n + c];
    ++j;
  }
}

// row . (q, q', 1, x, V), coefficient k, with q the polynomial `path`.
template <class T>
T along(const BodiesSystem<T>& sys, const T* row, const T* path, int k) {
  const int n = sys.n;
  T s = k == 0 ? row[2 * n] : T(0.0);
  for (int c = 0; c < n; ++c) {
    add_product(s, row[c], path[k * n + c]);
    if (k < 2) add_product(s, row[n + c], path[(k + 1) * n + c] * static_cast<double>(k + 1));
  }
  for (int i = 0; i < sys.speeds; ++i) {
    add_product(s, row[2 * n + 1 + i], sys.x[i * series_size + k]);
    if (k < 2) add_product(s, row[2 * n + 1 + sys.speeds + i], sys.V[i * series_size + k]);
  }
  return s;
}

// The equation in y, and its energy.
template <class T>
void set_equation(const BodiesSystem<T>& sys, const BodiesState<T>& state, BodiesStretch<T>& b) {
  Stretch<T>& s = b.s;
  const int n = sys.n, m = s.m, columns = sys.columns, held = sys.stuck_count;
  for (int a = 0; a < held; ++a) {
    const int j = sys.stuck[a], speed = sys.contact[j].speed;
    b.held[a] = dot(sys.D(j), state.z, n);
    for (int k = 1; k < 3; ++k)
      b.held[k * held + a] = speed < 0 ? T(0.0) : sys.V[speed * series_size + k - 1] * (1.0 / k);
  }
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < n; ++i) b.path[k * n + i] = dot(sys.yields + i * held, b.held + k * held, held);
  for (int i = 0; i < m; ++i) {
    const T* row = sys.projected + b.own[i] * columns;
    for (int j = 0; j < m; ++j) {
      T q(0.0), v(0.0);
      for (int c = 0; c < n; ++c) {
        add_product(q, row[c], b.N[c * m + j]);
        add_product(v, row[n + c], b.N[c * m + j]);
      }
      s.Q[i * m + j] = q;
      s.R[i * m + j] = v;
    }
    for (int k = 0; k < 3; ++k) s.f[k * m + i] = along(sys, row, b.path, k);
    s.w[i] = state.z[b.own[i]] - b.path[b.own[i]];
    s.w[m + i] = state.z[n + b.own[i]] - b.path[n + b.own[i]];
  }
  const auto folded = [&](int first, bool sloped, Real<T>* to) {  // N' (the matrix at `first`) N
    for (int i = 0; i < m; ++i)
      for (int j = 0; j < m; ++j) {
        Real<T> sum(0.0);
        for (int r = 0; r < n; ++r)
          for (int c = 0; c < n; ++c)
            sum += value(b.N[r * m + i]) * value(sys.values[first + r * n + c]) * value(b.N[c * m + j]);
        for (int k = 0; sloped && k < sys.contacts; ++k) {
          const Contact<T>& one = sys.contact[k];
          Real<T> left(0.0), right(0.0);
          for (int c = 0; c < n; ++c) {
            left += value(sys.D(k)[c]) * value(b.N[c * m + i]);
            right += value(sys.D(k)[c]) * value(b.N[c * m + j]);
          }
          if (one.mode != sticks) sum += value(one.slope) * left * right;
        }
        to[i * m + j] = sum;
      }
  };
  folded(sys.at.M, false, s.W);
  folded(sys.at.C, true, s.C);
  folded(sys.at.K, false, s.K);
}

}  // namespace stickslip::inline STICKSLIP_ISA
