// Hénon landing in all lanes at once, where bounds or the signs of S's Bernstein coefficients leave no doubt that it has no
// root in the step or just one. What is not that simple is left to the scalar code, lane by lane.
#pragma once

#include "stickslip/batch_surfaces.hpp"
#include "stickslip/lane_roots.hpp"

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

// Of the lanes in `asked`: who crosses S = 0 within h, and when. What bounds do not decide the signs of the coefficients
// may: all positive, or one change and below zero at the end, where the root is the only one.
template <int W>
Landings<W> land_lanes(const Lanes<W>* d, int order, const Lanes<W>& h, unsigned asked) {
  using L = Lanes<W>;
  using Vec = typename L::Vec;
  // a start so near to the surface that rounding decides is no simple case
  const unsigned inside = asked & mask_of<W>(d[0].v > 1e-9 * h.v * (abs(d[1]).v + abs(d[2]).v * h.v));
  Landings<W> out;
  out.clear = inside & stays_positive(d, order, h);
  const Vec end = evaluate(d, order, h).v, slope = d[1].v * h.v, bend = end - d[0].v - slope;
  const unsigned crossing = inside & mask_of<W>(end < 0);
  if (crossing != 0) {  // from the root of the parabola through start, slope and end
    out.t = L(h.v * 2.0 * d[0].v / (square_root(L(slope * slope - 4.0 * d[0].v * bend)).v - slope));
    const unsigned settled = iterate(d, order, h, crossing, out.t.v);
    out.found = settled & only_root(d, order, h, out.t);
  }
  const unsigned open = inside & ~(out.found | out.clear);
  if (open != 0) {
    const Signs<W> signs = count_signs(d, order, h);
    Vec t = signs.first * h.v;
    const unsigned once = open & mask_of<W>((signs.changes == 1.0) & (signs.below == 1.0));
    const unsigned settled = iterate(d, order, h, once, t);
    for (unsigned left = settled; left != 0; left &= left - 1) out.t.set(__builtin_ctz(left), t[__builtin_ctz(left)]);
    out.found |= settled;
    out.clear |= open & mask_of<W>(signs.below == 0.0);
  }
  out.undecided = asked & ~(out.found | out.clear);
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
