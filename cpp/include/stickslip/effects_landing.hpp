// Lanes of a model with effects and the surfaces they may meet, stand on or have left.
#pragma once

#include "stickslip/batch_surfaces.hpp"
#include "stickslip/effects_batch.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// The first exit of lane i within h, as the scalar kernel finds it.
template <int W>
Exit<double> exit_of(EffectBatch<W>& b, int i, int order, double h) {
  Watch<double> watches[watch_count];
  double c[watch_count][series_size];
  for (int w = 0; w < b.piece.watches; ++w) {
    const Watch<Lanes<W>>& from = b.piece.watch[w];
    for (int k = 0; k <= order; ++k) c[w][k] = from.c[k][i];
    watches[w] = {c[w],
                  from.has_lo ? from.lo[i] : 0.0,
                  from.has_hi ? from.hi[i] : 0.0,
                  from.rounding[i],
                  from.has_lo,
                  from.has_hi,
                  from.id};
  }
  Side on[watch_count];
  side_of(b, i, on);
  return first_exit(watches, b.piece.watches, order, h, on, true);
}

// Steps of the lanes that meet a surface are cut short there; `exits` says where. Returns those lanes.
template <int W>
unsigned land(EffectBatch<W>& b, int order, Lanes<W>& h, Exit<double>* exits) {
  unsigned suspected = 0, events = 0;
  for (int w = 0; w < b.piece.watches; ++w) {
    const Watch<Lanes<W>>& watch = b.piece.watch[w];
    const Lanes<W> rest = tail(watch.c, order, h);
    for (const Side side : {Side::lower, Side::upper})
      if (side == Side::lower ? watch.has_lo : watch.has_hi)
        suspected |= suspects<W>(watch, side, b.standing(watch.id, side), h, rest);
  }
  for (unsigned left = suspected & b.busy; left != 0; left &= left - 1) {
    const int i = __builtin_ctz(left);
    exits[i] = exit_of(b, i, order, h[i]);
    if (!exits[i].found) continue;
    h.set(i, exits[i].t);
    events |= 1u << i;
  }
  return events;
}

// A step on, a lane stands on no surface any more, unless it has not moved away from it.
template <int W>
void leave_surfaces(EffectBatch<W>& b, int order, const Lanes<W>& h) {
  typename Lanes<W>::Bits lower[watch_count] = {}, upper[watch_count] = {};
  for (int w = 0; w < b.piece.watches; ++w) {
    const Watch<Lanes<W>>& watch = b.piece.watch[w];
    lower[watch.id] = still_on(watch, Side::lower, b.on_lower[watch.id], order, h);
    upper[watch.id] = still_on(watch, Side::upper, b.on_upper[watch.id], order, h);
  }
  for (int id = 0; id < watch_count; ++id) {
    b.on_lower[id] = lower[id];
    b.on_upper[id] = upper[id];
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
