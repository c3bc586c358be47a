// Where a switching function S first becomes negative on a step: isolation, then Hénon's method.
//
// S is known as a polynomial in t (the series of the trajectory, branch frozen), so what other codes sample is
// decided here: the Bernstein coefficients of S bound it from below, and their sign changes count its roots. Two
// crossings inside one step, a graze, a root beside a surface just left: all are found or excluded, not missed.
//
// Landing is Hénon's step (Hénon 1982): S is the independent variable, dt/dS = 1/S', the step is -S, from the state
// before the crossing, repeated until |S| <= tol. The flow it follows is the series itself, so each pass costs one
// evaluation. Where S' vanishes the step is singular (a graze); a bracket around the root keeps it safe.
#pragma once

#include "stickslip/series.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Bernstein coefficients on [0, 1] of sum a_k x^k.
template <class R>
void to_bernstein(const R* a, int n, R* b) {
  R binomial(1.0);
  for (int k = 0; k <= n; ++k) {
    b[k] = a[k] / binomial;
    binomial = binomial * static_cast<double>(n - k) / static_cast<double>(k + 1);
  }
  for (int i = 1; i <= n; ++i)
    for (int j = n; j >= i; --j) b[j] = b[j] + b[j - 1];
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

// Land on S = 0 inside [a, b], where S(a) > 0 > S(b). `henon` off: bisection alone.
template <class R>
R land(const R* c, int n, R a, R b, bool henon) {
  R t = a;
  if (!henon) {
    for (int i = 0; i < 200 && a < b; ++i) {
      t = a + (b - a) * 0.5;
      if (t <= a || t >= b) break;
      (evaluate(c, n, t) > 0 ? a : b) = t;
    }
    return b;
  }
  R last = b - a;
  for (int i = 0; i < 100; ++i) {
    const R s = evaluate(c, n, t);
    (s > 0 ? a : b) = t;
    if (s == 0) return t;
    const R slope = evaluate_slope(c, n, t);
    R next = t - s / slope;  // dt = dS / S', dS = -S
    const bool inside = slope < 0 && next >= a && next <= b;
    if (!inside || magnitude(next - t) > 0.75 * last) next = a + (b - a) * 0.5;  // singular: bracket
    last = magnitude(next - t);
    if (next == t || last <= std::numeric_limits<R>::epsilon() * 0.5 * t) return next;
    t = next;
  }
  return t;
}

// Can S stay positive on (0, h]? A bound from the first two coefficients and the sum of the rest; `start` skips the
// coefficients that vanish at a surface just left. Cheap, and almost always enough.
template <class R>
bool surely_positive(const R* c, int n, R h, int start) {
  R rest(0.0), power = h * h;
  for (int k = start + 2; k <= n; ++k) {
    rest += magnitude(c[k]) * power;
    power *= h;
  }
  const R end = c[start] + c[start + 1] * h;
  return (c[start] < end ? c[start] : end) > rest;
}

// First time in (0, h] at which S turns negative. `on_surface`: S(0) = 0 exactly and the trajectory is leaving, so
// the root at 0 is divided out (and a slope of rounding size with it).
template <class R>
bool first_crossing(const R* c, int n, R h, bool on_surface, bool henon, R& t) {
  int start = 0;
  R scale(0.0), power(1.0);
  for (int k = 0; k <= n; ++k) {
    scale = largest(scale, R(magnitude(c[k]) * power));
    power *= h;
  }
  if (on_surface)
    start = (c[1] <= 0 && magnitude(c[1]) * h <= scale * 1e-10) || magnitude(c[1]) * h <= scale * 1e-13 ? 2 : 1;
  if (surely_positive(c, n, h, start)) return false;
  if (c[start] <= 0) {  // already outside (two surfaces met at once), or a departure that turns back at once
    t = R(0.0);
    return c[start] < 0 || n <= start || c[start + 1] < 0;
  }
  const R* d = c + start;
  const int m = n - start;
  R a[series_size], b[series_size];
  power = R(1.0);
  for (int k = 0; k <= m; ++k) {
    a[k] = d[k] * power;
    power *= h;
  }
  to_bernstein(a, m, b);
  R largest_b(0.0);
  for (int k = 0; k <= m; ++k) largest_b = largest(largest_b, R(magnitude(b[k])));
  const R noise = largest_b * std::numeric_limits<R>::epsilon() * 2.0;
  const Bracket r = first_sign_change(b, m, 0.0, 1.0, noise, 52);
  if (!r.found) return false;
  t = land(d, m, R(r.a * h), R(r.b * h), henon);
  return true;
}

}  // namespace stickslip::inline STICKSLIP_ISA
