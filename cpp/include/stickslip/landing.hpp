// Hénon landing in all lanes at once, for the common cases: S falls throughout the step, or is concave, so that it has
// one root if it ends below zero and none otherwise. What is not that simple is left to the scalar code, lane by lane.
#pragma once

#include "stickslip/batch.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <int W>
struct Landings {
  Lanes<W> t, horizon;  // of the crossing; how far the answer holds
  unsigned found = 0, clear = 0, undecided = 0;
};

// Of the lanes in `asked`: who crosses the surface within h, and when. Lanes in `standing` are leaving it.
template <int W>
Landings<W> land_lanes(const Watch<Lanes<W>>& watch, Side side, int order, const Lanes<W>& h, unsigned asked,
                       const typename Lanes<W>::Bits& on_surface) {
  using Vec = typename Lanes<W>::Vec;
  const unsigned standing = mask_of<W>(on_surface);
  const double sign = side == Side::lower ? 1.0 : -1.0;
  Vec c0 = sign * (watch.c[0].v - (side == Side::lower ? watch.lo.v : watch.hi.v));
  c0 = on_surface ? Vec{} : c0;
  const Vec c1 = sign * watch.c[1].v, c2 = sign * watch.c[2].v;
  // look no further than a little beyond the root of c0 + c1 t + c2 t^2: bounds are sharp on short intervals
  const Vec near = square_root(Lanes<W>(c2 < 0 ? c1 * c1 - 4.0 * c2 * c0 : Vec{})).v;
  const Vec reach = 1.25 * (c1 + near) / (-2.0 * c2);
  const Vec hv = ((c2 < 0) & (reach > 0) & (reach < h.v)) ? reach : h.v;
  Vec slope_rest = Vec{}, bend_rest = Vec{};  // bounds of S' and S''/2 beyond their first terms
  for (int k = order; k >= 3; --k) {
    const Vec c = watch.c[k].v, size = (c < 0 ? -c : c) * static_cast<double>(k);
    slope_rest = slope_rest * hv + size;
    bend_rest = bend_rest * hv + size * (0.5 * (k - 1));
  }
  const auto value_at = [&](const Vec& t, Vec& s, Vec& slope) {
    s = sign * watch.c[order].v;
    slope = Vec{};
    for (int k = order - 1; k >= 0; --k) {
      slope = slope * t + s;
      s = s * t + (k == 0 ? c0 : sign * watch.c[k].v);
    }
  };
  Vec s1, slope1;
  value_at(hv, s1, slope1);
  const Vec c1_end = c1 + c2 * hv * 2.0;
  const auto falling = (c1 > c1_end ? c1 : c1_end) < -(slope_rest * hv * hv);
  const auto concave = c2 < -(bend_rest * hv);
  // start: where S falls, the cubic t(S) through both ends with their slopes; else the parabola through S(0), S'(0)
  // and S(h), whose far root is meant
  const Vec span = s1 - c0, x = -c0 / span, q = (span - c1 * hv) / (hv * hv);
  const Vec hermite = x * x * (3.0 - 2.0 * x) * hv + x * (1.0 - x) * ((1.0 - x) * (span / c1) - x * (span / slope1));
  Vec root = c1 * c1 - 4.0 * q * c0;
  root = square_root(Lanes<W>(root > 0 ? root : Vec{})).v;
  const Vec parabola = (c1 + root) / (-2.0 * q);
  Vec t = falling ? hermite : parabola;
  t = ((t > 0) & (t < hv)) ? t : hv * 0.5;
  const auto inside = c0 > 0;
  const auto leaving = c1 > 0;
  const unsigned within = (mask_of<W>(inside) & ~standing) | (mask_of<W>(leaving) & standing);
  const unsigned simple = (mask_of<W>(concave) | (mask_of<W>(falling) & ~standing)) & within & asked;
  const unsigned crossing = simple & mask_of<W>(s1 < 0);
  unsigned settled = 0;
  for (int i = 0; i < 5 && (crossing & ~settled) != 0; ++i) {  // Hénon: dt = -S/S'
    Vec s, slope;
    value_at(t, s, slope);
    const Vec step = -s / slope;
    t += step;
    settled = mask_of<W>(((step < 0 ? -step : step) <= 1e-9 * hv) & (t > 0) & (t <= hv));
  }
  Landings<W> out;
  out.found = crossing & settled;
  out.clear = simple & ~crossing;
  out.undecided = (asked & ~simple) | (crossing & ~out.found);
  out.t = Lanes<W>(t);
  out.horizon = Lanes<W>(hv);
  return out;
}

}  // namespace stickslip::inline STICKSLIP_ISA
