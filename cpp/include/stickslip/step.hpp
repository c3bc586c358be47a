// How long a step may be: the last terms of the series against the tolerance.
#pragma once

#include "stickslip/effects_modes.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// With effects, what drives a switching function counts too: the friction or its demand, the static limits, the
// belt, the hidden states. Forces are compared as accelerations.
template <class T>
Real<T> effect_size(const System<T>& sys, const Mode& mode, const State<T>& begin, Piece<T>& piece, int k) {
  using R = Real<T>;
  const EffectSeries<T>& fx = piece.fx;
  R size = magnitude(value(fx.friction[k] * sys.rig.over_a1));
  if (mode.contact == 0) size = largest(size, R(magnitude(value(fx.limit_minus[k] * sys.rig.over_a1))));
  each_acting(sys, mode, begin, piece, [&](const auto& at) {
    using E = typename std::decay_t<decltype(at)>::Effect;
    if constexpr (requires { &E::template decides<T>; })
      if (const T* c = E::decides(at)) size = largest(size, R(magnitude(value(c[k]))));
  });
  if (acts(sys, moves_belt)) size = largest(size, R(magnitude(value(fx.belt[k]))));
  return size;
}

template <class T>
Real<T> step_plain(const System<T>& sys, const Series<T>& s, int order, double rtol, double atol) {
  using R = Real<T>;
  const auto size = [&](int k) { return largest(R(magnitude(value(s.x2[k]))), R(magnitude(value(s.y2[k])))); };
  return step_from<T>(size(order), size(order - 1), motion_scale(sys, s), order, rtol, atol);
}

template <class T>
Real<T> step_length(const System<T>& sys, const Mode& mode, const State<T>& begin, Piece<T>& piece, int order,
                    double rtol, double atol) {
  using R = Real<T>;
  const Series<T>& s = piece.s;
  if (sys.structure.effects == 0) return step_plain(sys, s, order, rtol, atol);
  const auto size = [&](int k) {
    const R motion = largest(R(magnitude(value(s.x2[k]))), R(magnitude(value(s.y2[k]))));
    return largest(motion, effect_size(sys, mode, begin, piece, k));
  };
  const R scale = motion_scale(sys, s);
  R h = step_from<T>(size(order), size(order - 1), scale, order, rtol, atol);
  const R allowed((R(atol) + R(rtol) * scale) * tolerance_share);
  each_acting(sys, mode, begin, piece, [&](const auto& at) {
    using E = typename std::decay_t<decltype(at)>::Effect;
    if constexpr (requires { &E::template shorten<T>; }) h = E::shorten(at, order, h, allowed);
  });
  return h;
}

// What effects do once the step is known; they may make it shorter.
template <class T>
void settle_step(const System<T>& sys, const Mode& mode, const State<T>& begin, Piece<T>& piece, int order, Real<T>& h,
                 double rtol, double atol) {
  each_acting(sys, mode, begin, piece, [&](const auto& at) {
    using E = typename std::decay_t<decltype(at)>::Effect;
    if constexpr (requires { &E::template settle<T>; }) E::settle(at, order, h, rtol, atol);
  });
}

}  // namespace stickslip::inline STICKSLIP_ISA
