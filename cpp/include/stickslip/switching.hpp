// Switching functions of a piece, as polynomials with an interval they must stay in.
#pragma once

#include "stickslip/henon.hpp"
#include "stickslip/watch.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
struct Exit {
  bool found = false;
  Real<T> t{};    // time since the start of the piece
  int watch = 0;  // index in the piece's list
  Side side = Side::none;
};

// t of the crossing in the number type: one Newton step on the implicit equation S(t, p) = 0 gives dt/dp.
template <class T>
T with_derivatives(const T* c, const T& bound, int order, const Real<T>& t) {
  if constexpr (requires(T x) { x.d[0]; }) {
    const T s = evaluate(c, order, t) - bound;
    const double slope = value(evaluate_slope(c, order, t));
    T r(t);
    if (slope != 0)
      for (int i = 0; i < T::chunks; ++i) r.d[i] = -s.d[i] / slope;
    return r;
  } else {
    return t;
  }
}

// A series at a time that itself carries derivatives: first-order expansion about its value, which is exact here.
template <class T>
T evaluate_at(const T* c, int order, const T& h) {
  if constexpr (requires(T x) { x.d[0]; }) {
    T sum = c[order];
    double slope = 0;
    for (int k = order - 1; k >= 0; --k) {
      slope = slope * h.v + sum.v;
      sum = sum * h.v + c[k];
    }
    for (int i = 0; i < T::chunks; ++i) sum.d[i] += slope * h.d[i];
    return sum;
  } else {
    return evaluate(c, order, h);
  }
}

// The same of two series in step, so that neither waits for itself.
template <class T>
void evaluate_both_at(const T* a, const T* b, int order, const T& h, T& at_a, T& at_b) {
  T one = a[order], other = b[order];
  double slope = 0, other_slope = 0;
  for (int k = order - 1; k >= 0; --k) {
    slope = slope * h.v + one.v;
    other_slope = other_slope * h.v + other.v;
    one = one * h.v + a[k];
    other = other * h.v + b[k];
  }
  for (int i = 0; i < T::chunks; ++i) {
    one.d[i] += slope * h.d[i];
    other.d[i] += other_slope * h.d[i];
  }
  at_a = one;
  at_b = other;
}

// The value alone.
template <class T>
double evaluate_value(const T* c, int order, double h) {
  double sum = c[order].v;
  for (int k = order - 1; k >= 0; --k) sum = sum * h + c[k].v;
  return sum;
}

// S = c - lo or hi - c, >= 0 inside, as real coefficients.
template <class T>
void switching_polynomial(const Watch<T>& watch, Side side, bool leaving, int order, Real<T>* c) {
  const Real<T> sign(side == Side::lower ? 1.0 : -1.0);
  for (int k = 0; k <= order; ++k) c[k] = sign * value(watch.c[k]);
  c[0] -= sign * value(side == Side::lower ? watch.lo : watch.hi);
  if (leaving) leave_from(c, watch.rounding);
}

// Does a bound from the first coefficients exclude every exit through `side` within h? `rest` bounds what follows the
// linear part; on a surface being left, the linear part is divided by t.
template <class T>
bool surely_inside(const Watch<T>& watch, Side side, bool leaving, const Real<T>& h, const Real<T>& rest) {
  using R = Real<T>;
  const R sign(side == Side::lower ? 1.0 : -1.0);
  if (leaving) {
    const R quadratic = value(watch.c[2]) * h;
    const R c1 = sign * value(watch.c[1]), end = c1 + sign * quadratic;
    if (magnitude(c1) * h + rest <= watch.rounding) return true;
    return (c1 < end ? c1 : end) * h > rest - magnitude(quadratic) * h;
  }
  const R c0 = sign * (value(watch.c[0]) - value(side == Side::lower ? watch.lo : watch.hi));
  const R end = c0 + sign * value(watch.c[1]) * h;
  return (c0 < end ? c0 : end) > rest;
}

// Does a trajectory that stands on a bound stand on it still, h later?
template <class T>
bool still_on(const Watch<T>& watch, Side side, int order, const Real<T>& h) {
  const Real<T> bound = value(side == Side::lower ? watch.lo : watch.hi);
  return side != Side::none && magnitude(value(evaluate(watch.c, order, h)) - bound) < watch.rounding;
}

// sum over k >= 2 of |c_k| h^k; even and odd powers in chains of their own.
template <class T>
Real<T> tail(const T* c, int order, const Real<T>& h) {
  using R = Real<T>;
  const R square = h * h;
  R even(0.0), odd(0.0);
  int k = order;
  if (k % 2 == 0) even = magnitude(value(c[k--]));
  for (; k >= 3; k -= 2) {
    odd = odd * square + magnitude(value(c[k]));
    even = even * square + magnitude(value(c[k - 1]));
  }
  return (odd * h + even) * square;
}

// The earliest exit of all watches within (0, h]; ties go to the first in the list.
template <class T>
Exit<T> first_exit(const Watch<T>* watches, int count, int order, Real<T> h, const Side* on, bool henon) {
  using R = Real<T>;
  Exit<T> best;
  for (int w = 0; w < count; ++w) {
    const Watch<T>& watch = watches[w];
    const R rest = tail(watch.c, order, h);
    for (const Side side : {Side::lower, Side::upper}) {
      if (!(side == Side::lower ? watch.has_lo : watch.has_hi)) continue;
      const bool leaving = on[watch.id] == side;
      if (surely_inside(watch, side, leaving, h, rest)) continue;
      R c[series_size], t{};
      switching_polynomial(watch, side, leaving, order, c);
      if (!first_crossing(c, order, h, leaving, henon, t)) continue;
      if (!best.found || t < best.t) {
        best.found = true;
        best.t = t;
        best.watch = w;
        best.side = side;
        h = t;
      }
    }
  }
  return best;
}

}  // namespace stickslip::inline STICKSLIP_ISA
