// Lanes and the surfaces they may meet, stand on or have left.
#pragma once

#include "stickslip/batch.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Lanes whose exit through `side` a bound does not exclude, as a mask of bits; those in `standing` are leaving the surface.
template <int W>
unsigned suspects(const Watch<Lanes<W>>& watch, Side side, const typename Lanes<W>::Bits& standing, const Lanes<W>& h,
                  const Lanes<W>& rest) {
  using Vec = typename Lanes<W>::Vec;
  const double sign = side == Side::lower ? 1.0 : -1.0;
  const Vec bound = side == Side::lower ? watch.lo.v : watch.hi.v;
  const Vec c0 = sign * (watch.c[0].v - bound), c1 = sign * watch.c[1].v, c2 = sign * watch.c[2].v * h.v;
  const Vec end = c0 + c1 * h.v, end1 = c1 + c2;
  const Vec free = (c0 < end ? c0 : end) - rest.v;
  const Vec left = (c1 < end1 ? c1 : end1) * h.v - rest.v + (c2 < 0 ? -c2 : c2) * h.v;
  const Vec moves = (c1 < 0 ? -c1 : c1) * h.v + rest.v;
  return mask_of<W>(standing ? (left <= 0) & (moves > watch.rounding.v) : free <= 0);
}
template <int W>
unsigned suspects(const Batch<W>& b, const Watch<Lanes<W>>& watch, Side side, const Lanes<W>& h, const Lanes<W>& rest) {
  return suspects<W>(watch, side, b.standing(side), h, rest) & b.busy;
}

template <int W>
Side side_of(const Batch<W>& b, int i) {
  return b.on_lower[i] != 0 ? Side::lower : b.on_upper[i] != 0 ? Side::upper : Side::none;
}

// The lanes of those in `standing` that stand on a bound still, h later.
template <int W>
typename Lanes<W>::Bits still_on(const Watch<Lanes<W>>& watch, Side side, const typename Lanes<W>::Bits& standing,
                                 int order, const Lanes<W>& h) {
  if (mask_of<W>(standing) == 0 || mask_of<W>(watch.rounding.v > 0) == 0) return typename Lanes<W>::Bits{};
  const Lanes<W> off = evaluate(watch.c, order, h) - (side == Side::lower ? watch.lo : watch.hi);
  return standing & (abs(off).v < watch.rounding.v);
}

// A step on, a lane stands on no surface any more, unless it has not moved away from it.
template <int W>
void leave_surfaces(Batch<W>& b, const Lanes<W>& h) {
  b.on_lower = still_on(b.piece.watch[0], Side::lower, b.on_lower, linear_order, h);
  b.on_upper = still_on(b.piece.watch[0], Side::upper, b.on_upper, linear_order, h);
}

// The first exit of lane i through `side` within h, located as the scalar kernel does.
template <int W>
bool locate(const Batch<W>& b, const Watch<Lanes<W>>& watch, Side side, int i, int order, double& h) {
  const bool leaving = b.standing(side)[i] != 0;
  const double sign = side == Side::lower ? 1.0 : -1.0;
  double c[series_size], t;
  for (int k = 0; k <= order; ++k) c[k] = sign * watch.c[k][i];
  c[0] -= sign * (side == Side::lower ? watch.lo[i] : watch.hi[i]);
  if (leaving) leave_from(c, watch.rounding[i]);
  if (!first_crossing(c, order, h, leaving, true, t)) return false;
  h = t;
  return true;
}

}  // namespace stickslip::inline STICKSLIP_ISA
