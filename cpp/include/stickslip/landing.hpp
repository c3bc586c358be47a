// Hénon landing in all lanes at once, where the signs of S's Bernstein coefficients leave no doubt that it has no root in
// the step or just one. What is not that simple is left to the scalar code, lane by lane.
#pragma once

#include "stickslip/batch_surfaces.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <int W>
struct Landings {
  Lanes<W> t;  // of the crossing
  unsigned found = 0, clear = 0, undecided = 0;
};

// S, positive inside, of every lane; of lanes that are leaving the surface S/t, whose root at 0 is divided out.
template <int W>
void positive_inside(const Batch<W>& b, const Watch<Lanes<W>>& watch, Side side, int order, Lanes<W>* d) {
  using Vec = typename Lanes<W>::Vec;
  const double sign = side == Side::lower ? 1.0 : -1.0;
  d[0].v = sign * (watch.c[0].v - (side == Side::lower ? watch.lo.v : watch.hi.v));
  for (int k = 1; k <= order; ++k) d[k].v = sign * watch.c[k].v;
  const typename Lanes<W>::Bits standing = b.standing(side);
  if (mask_of<W>(standing) == 0) return;
  for (int k = 0; k < order; ++k) d[k].v = standing ? d[k + 1].v : d[k].v;
  d[order].v = standing ? Vec{} : d[order].v;
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
  Lanes<W> b[series_size];
  Vec scale = Vec{} + 1.0, largest = Vec{};
  for (int k = 0; k <= n; ++k) {  // d_k h^k / binomial(n, k)
    b[k].v = d[k].v * scale;
    if (k < n) scale *= h.v * ((k + 1) * reciprocals.r[n - k]);
  }
  int i = 1;
  for (; i < n; i += 2) {  // two rows of the triangle of sums at once
    for (int j = n; j > i; --j) b[j].v = (b[j].v + b[j - 2].v) + 2.0 * b[j - 1].v;
    b[i].v += b[i - 1].v;
  }
  if (i == n) b[n].v += b[n - 1].v;
  for (int k = 0; k <= n; ++k) largest = max(Lanes<W>(largest), abs(b[k])).v;
  const Vec zero = Vec{}, one = zero + 1.0, noise = largest * (2.0 * std::numeric_limits<double>::epsilon());
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

// Of the lanes in `asked`: who crosses S = 0 within h, and when. Decided are those whose coefficients are all positive,
// and those that change sign once, ending below zero: then the root is the only one.
template <int W>
Landings<W> land_lanes(const Lanes<W>* d, int order, const Lanes<W>& h, unsigned asked) {
  using L = Lanes<W>;
  using Vec = typename L::Vec;
  const Signs<W> signs = count_signs(d, order, h);
  // a start so near to the surface that rounding decides is no simple case
  const unsigned inside = asked & mask_of<W>(d[0].v > 1e-9 * h.v * (abs(d[1]).v + abs(d[2]).v * h.v));
  const unsigned crossing = inside & mask_of<W>((signs.changes == 1.0) & (signs.below == 1.0));
  Vec t = signs.first * h.v;
  unsigned settled = 0;
  for (int i = 0; i < 8 && (crossing & ~settled) != 0; ++i) {  // Hénon: dt = -S/S'
    L s, slope;
    value_and_slope(d, order, L(t), s, slope);
    const Vec step = -s.v / slope.v;
    t += step;
    settled = mask_of<W>((abs(L(step)).v <= 1e-9 * h.v) & (t > 0) & (t <= h.v));
  }
  Landings<W> out;
  out.found = crossing & settled;
  out.clear = inside & mask_of<W>(signs.below == 0.0);
  out.undecided = asked & ~(out.found | out.clear);
  out.t = L(t);
  return out;
}

// Shortens h of the lanes that meet the surface first, and notes them in `events`.
template <int W>
void land_side(const Batch<W>& b, const Watch<Lanes<W>>& watch, Side side, unsigned asked, int p, Lanes<W>& h,
               Side* through, unsigned& events) {
  const auto take = [&](int i, double t) {
    h.set(i, t);
    events |= 1u << i;
    through[i] = side;
  };
  Lanes<W> d[series_size];
  positive_inside(b, watch, side, p, d);
  const Landings<W> easy = land_lanes(d, p, h, asked);
  for (unsigned left = easy.found; left != 0; left &= left - 1) take(__builtin_ctz(left), easy.t[__builtin_ctz(left)]);
  for (unsigned left = easy.undecided; left != 0; left &= left - 1) {
    const int i = __builtin_ctz(left);
    double t = h[i];
    if (locate(b, watch, side, i, p, t)) take(i, t);
  }
}

// The suspects of both sides, the side with more of them first.
template <int W>
void land_first(const Batch<W>& b, const Watch<Lanes<W>>& watch, unsigned lower, unsigned upper, int p, Lanes<W>& h,
                Side* through, unsigned& events) {
  const bool first_upper = __builtin_popcount(upper) > __builtin_popcount(lower);
  land_side(b, watch, first_upper ? Side::upper : Side::lower, first_upper ? upper : lower, p, h, through, events);
  unsigned other = first_upper ? lower : upper;
  if (other == 0) return;  // up to where the first side was met, less may be in doubt
  const Side side = first_upper ? Side::lower : Side::upper;
  if (events != 0) other = suspects(b, watch, side, h, tail(watch.c, p, h));
  if (other != 0) land_side(b, watch, side, other, p, h, through, events);
}

}  // namespace stickslip::inline STICKSLIP_ISA
