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

#include "stickslip/bernstein.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// S, positive inside, of who leaves the surface S = 0: it starts on it. Where it would come back after an excursion less
// deep than rounding, its first slope is rounding.
template <class R>
void leave_from(R* c, const R& rounding) {
  c[0] = R(0.0);
  if (c[1] < 0 && c[1] * c[1] < c[2] * rounding * 4.0) c[1] = R(0.0) - c[1];
}

// S and S' at t, together, in even and odd powers: short chains instead of two passes.
template <class R>
void value_and_slope(const R* c, int n, R t, R& s, R& slope) {
  const R square = t * t;
  R even(0.0), odd(0.0), even_slope(0.0), odd_slope(0.0);  // slopes with respect to t^2
  int k = n;
  if (k % 2 == 0) even = c[k--];
  for (; k >= 1; k -= 2) {
    odd_slope = odd_slope * square + odd;
    odd = odd * square + c[k];
    even_slope = even_slope * square + even;
    even = even * square + c[k - 1];
  }
  s = even + odd * t;
  slope = odd + (even_slope + odd_slope * t) * (t + t);
}

// Land on S = 0 inside [a, b], where S(a) > 0 > S(b), from `guess` in it. `henon` off: bisection alone.
template <class R>
R land(const R* c, int n, R a, R b, R guess, bool henon) {
  if (!henon) {
    for (R t = a + (b - a) * 0.5; t > a && t < b; t = a + (b - a) * 0.5) (evaluate(c, n, t) > 0 ? a : b) = t;
    return b;
  }
  const R settled = square_root(std::numeric_limits<R>::epsilon()) * 0.1;  // the next step would be its square
  R t = guess, last = b - a, s, slope;
  for (int i = 0; i < 100; ++i) {
    value_and_slope(c, n, t, s, slope);
    if (s == 0) return t;
    (s > 0 ? a : b) = t;
    R next = t - s / slope;  // dt = dS / S', dS = -S
    const bool newton = slope < 0 && next >= a && next <= b && magnitude(next - t) <= 0.75 * last;
    if (!newton) next = a + (b - a) * 0.5;  // singular: bracket
    if (!newton && !(next > a && next < b)) return b;
    last = newton ? R(magnitude(next - t)) : R(b - a);
    t = next;
    if (newton && last <= settled * b) return t;
  }
  return t;
}

// t(0) of the cubic t(S) through both ends of [0, h] with their slopes dt/dS: where Hénon's step starts from.
template <class R>
R inverse_hermite(R s0, R slope0, R s1, R slope1, R h) {
  const R span = s1 - s0, x = -s0 / span;  // fraction of the way in S
  const R m0 = span / slope0, m1 = span / slope1;
  const R t = x * x * (3 - 2 * x) * h + x * (1 - x) * ((1 - x) * m0 - x * m1);
  return t > 0 && t < h ? t : R(x * h);
}

// Is S falling throughout [0, h]? A bound; then a root in it is the only one.
template <class R>
bool surely_falling(const R* c, int n, R h) {
  const R square = h * h;
  R even(0.0), odd(0.0);
  int k = n;
  if (k % 2 == 0 && k >= 4) even = magnitude(c[k]) * static_cast<double>(k);
  if (k % 2 == 0) --k;
  for (; k >= 5; k -= 2) {
    odd = odd * square + magnitude(c[k]) * static_cast<double>(k);
    even = even * square + magnitude(c[k - 1]) * static_cast<double>(k - 1);
  }
  if (k == 3) odd = odd * square + magnitude(c[3]) * 3.0;
  const R rest = (odd + even * h) * square;
  const R end = n < 2 ? c[1] : c[1] + c[2] * h * 2.0;
  return (c[1] > end ? c[1] : end) < -rest;
}

// A trajectory leaves S = 0 towards S > 0: the order of the root at t = 0. Coefficients that are small beside the
// motion over h, or negative by an error of the tolerance's size, are those of a departure without velocity. One that
// turns back at once still takes what velocity it has: the excursion is short, and where it ends may hold the block.
template <class R>
int departure_order(const R* c, int n, R h) {
  R scale(0.0), power(h);
  for (int k = 1; k <= n; ++k, power *= h) scale = largest(scale, R(magnitude(c[k]) * power));
  power = h;
  for (int k = 1; k < n; ++k, power *= h) {
    const R size = c[k] * power;
    if (size > scale * 1e-10) return k;
    if (size < scale * -1e-3) return c[1] > 0 ? 1 : k;
  }
  return 1;
}

// First time in (0, h] at which S turns negative. `on_surface`: S(0) = 0 exactly and the trajectory is leaving, so
// the root at 0 is divided out.
template <class R>
bool first_crossing(const R* c, int n, R h, bool on_surface, bool henon, R& t) {
  const int start = on_surface || c[0] == 0 ? departure_order(c, n, h) : 0;
  if (c[start] <= 0) {  // already outside (two surfaces met at once), or a departure that turns back at once
    t = R(0.0);
    return c[start] < 0 || n <= start || c[start + 1] < 0;
  }
  if (start == 0 && c[1] < 0 && c[0] < c[1] * h * -1e-14) {  // on the surface to rounding, and going through it
    t = -c[0] / c[1];
    return true;
  }
  const R* d = c + start;
  const int m = n - start;
  if (surely_falling(d, m, h)) {
    R end, slope;
    value_and_slope(d, m, h, end, slope);
    if (end >= 0) return false;
    t = land(d, m, R(0.0), h, inverse_hermite(d[0], d[1], end, slope, h), henon);
    return true;
  }
  R a[series_size], b[series_size];
  R power(h);
  a[0] = d[0];
  for (int k = 1; k <= m; ++k, power *= h) a[k] = d[k] * power;
  to_bernstein(a, m, b);
  R largest_b(0.0);
  for (int k = 0; k <= m; ++k) largest_b = largest(largest_b, R(magnitude(b[k])));
  const R noise = largest_b * std::numeric_limits<R>::epsilon() * 2.0;
  const Bracket r = first_sign_change(b, m, 0.0, 1.0, noise, 52);
  if (!r.found) return false;
  const R middle = R(r.a * h) + R((r.b - r.a) * h) * 0.5;
  t = land(d, m, R(r.a * h), R(r.b * h), middle, henon);
  return true;
}

}  // namespace stickslip::inline STICKSLIP_ISA
