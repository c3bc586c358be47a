// Questions to the polynomials of all lanes at once: is S positive all over a step, and has it just one root in it?
#pragma once

#include "stickslip/bernstein.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Hénon's iteration from t in the lanes `asked`, dt = -S/S'; the lanes where it ends within (0, h].
template <int W>
unsigned iterate(const Lanes<W>* d, int n, const Lanes<W>& h, unsigned asked, typename Lanes<W>::Vec& t) {
  unsigned settled = 0;
  for (int i = 0; i < 8 && (asked & ~settled) != 0; ++i) {
    Lanes<W> s, slope;
    value_and_slope(d, n, Lanes<W>(t), s, slope);
    const typename Lanes<W>::Vec step = -s.v / slope.v;
    t += step;
    settled = mask_of<W>((abs(Lanes<W>(step)).v <= 1e-9 * h.v) & (t > 0) & (t <= h.v));
  }
  return asked & settled;
}

// A lower bound, over [0, h], of the polynomial whose first four coefficients are c: its cubic's Bernstein coefficients, less
// `rest`, the sum over k >= 4 of |c_k| h^(k - 4).
template <int W>
Lanes<W> lower_bound(const Lanes<W>* c, const Lanes<W>& rest, const Lanes<W>& h) {
  const Lanes<W> x = h * h, linear = c[1] * h, square = c[2] * x;
  const Lanes<W> inner = min(c[0] + linear * (1.0 / 3), c[0] + linear * (2.0 / 3) + square * (1.0 / 3));
  return min(min(c[0], inner), c[0] + linear + square + c[3] * h * x) - rest * x * x;
}

// The lanes where S is positive all over the step.
template <int W>
unsigned stays_positive(const Lanes<W>* d, int n, const Lanes<W>& h) {
  Lanes<W> rest(0.0);
  for (int k = n; k >= 4; --k) rest = rest * h + abs(d[k]);
  return mask_of<W>(lower_bound(d, rest, h).v > 0);
}

// The lanes where t is the only root of S in the step: S/(t - x) is positive all over it.
template <int W>
unsigned only_root(const Lanes<W>* d, int n, const Lanes<W>& h, const Lanes<W>& t) {
  Lanes<W> q = -d[n], rest(0.0), first[4];
  for (int k = n - 1; k > 3; --k) {
    rest = rest * h + abs(q);
    q = q * t - d[k];
  }
  for (int k = 3; k >= 0; --k) {
    first[k] = q;
    q = q * t - d[k];
  }
  return mask_of<W>(lower_bound(first, rest, h).v > 0);
}

// S on [0, h] in Bernstein's form, lane by lane: how often its coefficients change sign, and the first zero of the line
// through them, as a share of h.
template <int W>
struct Signs {
  typename Lanes<W>::Vec below, changes, first;  // below: 1 where S may get below zero
};

template <int W>
Signs<W> count_signs(const Lanes<W>* d, int n, const Lanes<W>& h) {
  using Vec = typename Lanes<W>::Vec;
  Lanes<W> a[series_size], b[series_size], scale(1.0);
  for (int k = 0; k <= n; ++k) {
    a[k] = d[k] * scale;
    scale *= h;
  }
  to_bernstein(a, n, b);
  Vec largest{};
  for (int k = 0; k <= n; ++k) largest = max(Lanes<W>(largest), abs(b[k])).v;
  // a coefficient within rounding of zero has the sign of the one before
  const Vec zero{}, one = zero + 1.0, noise = largest * (2.0 * std::numeric_limits<double>::epsilon());
  Signs<W> out{zero, zero, zero};
  Vec sign = one;
  for (int k = 1; k <= n; ++k) {
    const Vec now = b[k].v > 0 ? one : (b[k].v < -noise ? -one : sign);
    const auto turned = now != sign;
    const auto newly = turned & (out.changes == 0);
    out.first = newly ? static_cast<double>(k) - b[k].v / (b[k].v - b[k - 1].v) : out.first;
    out.changes += turned ? one : zero;
    out.below = b[k].v < -noise ? one : out.below;
    sign = now;
  }
  out.first *= reciprocals.r[n];
  return out;
}

}  // namespace stickslip::inline STICKSLIP_ISA
