// Switching functions of a piece with effects.
#pragma once

#include "stickslip/effects_piece.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
void watch_contact_effects(const System<T>& sys, const Mode& mode, int order, Piece<T>& piece) {
  EffectSeries<T>& fx = piece.fx;
  if (mode.contact == 0) {  // margins to the static limits, q = -friction
    Watch<T>& upper = watch_series(piece, watch_contact, fx.limit_minus, 1.0, order);
    Watch<T>& lower = watch_series(piece, watch_demand, fx.limit_plus, 1.0, order);
    T *up = piece.switching[piece.watches - 2], *down = piece.switching[piece.watches - 1];
    for (int k = 0; k <= order; ++k) {
      up[k] = up[k] + fx.friction[k];
      down[k] = down[k] - fx.friction[k];
    }
    above(upper, T(0.0));
    above(lower, T(0.0));
    upper.rounding = lower.rounding = value(up[0] + down[0]) * limit_rounding;
    return;
  }
  above(watch_series(piece, watch_contact, fx.v, mode.contact, order), T(0.0));
  const Branch<T>& b = branch_of(sys, mode.contact);
  if (b.has_kink) {
    Watch<T>& w = watch_series(piece, watch_kink, fx.u, 1.0, order);
    mode.saturated ? above(w, b.kink) : below(w, b.kink);
  }
}

template <class T>
void watch_effects(const System<T>& sys, const Mode& mode, const State<T>& begin, int order, Piece<T>& piece) {
  piece.watches = 0;
  watch_contact_effects(sys, mode, order, piece);
  each_acting(sys, mode, begin, piece, [&](const auto& at) {
    using E = typename std::decay_t<decltype(at)>::Effect;
    if constexpr (HasSurface<E>) E::watch(at, order);
  });
}

}  // namespace stickslip::inline STICKSLIP_ISA
