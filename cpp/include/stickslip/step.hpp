// How long a step may be: the last terms of the series against the tolerance.
#pragma once

#include <algorithm>

#include "stickslip/effects_modes.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Longest step whose last two terms stay below the tolerance (Jorba and Zou 2005). `tolerance_share` leaves room for
// the error to add up over a cycle of stick-slip.
constexpr double tolerance_share = 0.1;

template <class T>
Real<T> step_from(const Real<T>& last, const Real<T>& before, const Real<T>& scale, int order, double rtol,
                  double atol) {
  using R = Real<T>;
  const R tiny(1e-300);
  const R allowed = rough_log2((R(atol) + R(rtol) * scale) * tolerance_share + tiny);
  const R h1 = (allowed - rough_log2(last + tiny)) * (1.0 / order);
  const R h2 = (allowed - rough_log2(before + tiny)) * (1.0 / (order - 1));
  const R safety(-0.7 / (order - 1) * 1.4426950408889634);
  return rough_exp2(R(smallest(h1, h2) + safety));
}

// With effects, what drives a switching function counts too: the friction or its demand, the static limits, the
// belt, the hidden states. Forces are compared as accelerations.
template <class T>
Real<T> effect_size(const System<T>& sys, const Mode& mode, const EffectSeries<T>& fx, int k) {
  using R = Real<T>;
  const auto has = [&](Effect effect) { return (sys.structure.effects & effect) != 0; };
  R size = magnitude(value(fx.friction[k] * sys.rig.over_a1));
  if (mode.contact == 0) size = largest(size, R(magnitude(value(fx.limit_minus[k] * sys.rig.over_a1))));
  if (has(fx_memory) && mode.contact != 0) size = largest(size, R(magnitude(value(fx.w[k]))));
  if (has(fx_ripple) || has(fx_droop)) size = largest(size, R(magnitude(value(fx.belt[k]))));
  return size;
}

// h of every lane, shortened until `allows(lane, h)`.
template <class R, class Allows>
R shortened(R h, const Allows& allows) {
  for (int i = 0; i < lane_count<R>; ++i) {
    double step = lane(h, i);
    for (int tries = 0; tries < 200 && !allows(i, step); ++tries) step *= 0.8;
    set_lane(h, i, step);
  }
  return h;
}

// A narrow Stribeck peak ahead hides from the last terms: far from it e^a is nothing, and its series only starts to
// grow. With X = sum |a_k| h^k the terms left out are below e^(a_0) X^p/p! (e^X beyond X = p): shorten h until that is
// allowed.
template <class T>
Real<T> peak_step(const System<T>& sys, const EffectSeries<T>& fx, int order, const Real<T>& h,
                  const Real<T>& allowed) {
  return shortened(h, [&](int i, double step) {
    const auto real = [&](const T& x) { return lane(value(x), i); };
    const double u = real(fx.u[0]) / real(sys.p[stribeck_peak_v_s]);
    double tall = std::abs(real(sys.p[stribeck_peak_dT]));
    if constexpr (requires(T x) { x.d[0]; })  // one of no height is differentiated by it
      for (int k = 0; k < T::size; ++k) tall = std::max(tall, std::abs(sys.p[stribeck_peak_dT].derivative(k)));
    const double height = tall * std::abs(real(sys.rig.over_a1)) + 1e-300;
    double x = 0;
    for (int k = order; k >= 1; --k) x = (x + std::abs(real(fx.peak_slope[k])) / k) * step;
    const double grown = x < order ? order * std::log(x + 1e-300) - std::lgamma(order + 1.0) : x;
    return grown <= std::log(lane(allowed, i) / height) + u * u;
  });
}

// tanh(y2/v_c) has its nearest pole pi/2 beside the real axis, and seen from afar hides as the peak does: y2 may move a
// share of its distance from there.
template <class T>
Real<T> creep_step(const System<T>& sys, const Series<T>& s, int order, const Real<T>& h) {
  return shortened(h, [&](int i, double step) {
    const auto real = [&](const T& x) { return lane(value(x), i); };
    const double v_c = real(sys.p[pivot_dry_friction_v_c]), y2 = real(s.y2[0]);
    double moves = 0;
    for (int k = order; k >= 1; --k) moves = (moves + std::abs(real(s.y2[k]))) * step;
    return moves <= 0.3 * std::sqrt(y2 * y2 + v_c * v_c * 2.467);
  });
}

template <class T>
Real<T> step_plain(const System<T>& sys, const Series<T>& s, int order, double rtol, double atol) {
  using R = Real<T>;
  const auto size = [&](int k) { return largest(R(magnitude(value(s.x2[k]))), R(magnitude(value(s.y2[k])))); };
  return step_from<T>(size(order), size(order - 1), motion_scale(sys, s), order, rtol, atol);
}

// The lag only reads the motion, and its equation is linear: where tau is shorter than the motion's own step h, m is the
// polynomial that follows what is read, m_k = reads_k - tau (k + 1) m_(k+1), and a rest that dies out as e^(-t/tau).
// Otherwise m is a series like the others and h is held to its last terms.
template <class T>
void settle_lag(const System<T>& sys, Piece<T>& piece, int order, Real<T>& h, double rtol, double atol) {
  using R = Real<T>;
  EffectSeries<T>& fx = piece.fx;
  const T tau = sys.p[sensor_lag_tau];
  const auto slow = greater(value(tau), h);
  const auto size = [&](int k) { return R(magnitude(value(fx.m[k]))); };
  const R limited =
      smallest(h, step_from<T>(size(order), size(order - 1), motion_scale(sys, piece.s), order, rtol, atol));
  h = select(slow, limited, h);
  fx.lag_settles = true;
  const T start = fx.m[0];
  T follows = fx.reads[order];
  fx.m[order] = select(slow, fx.m[order], follows);
  for (int k = order - 1; k >= 0; --k) {
    follows = fx.reads[k] - tau * follows * static_cast<double>(k + 1);
    fx.m[k] = select(slow, fx.m[k], follows);
  }
  fx.lag_rest = start - fx.m[0];
}

template <class T>
Real<T> step_length(const System<T>& sys, const Mode& mode, const Piece<T>& piece, int order, double rtol,
                    double atol) {
  using R = Real<T>;
  const Series<T>& s = piece.s;
  if (sys.structure.effects == 0) return step_plain(sys, s, order, rtol, atol);
  const auto size = [&](int k) {
    const R motion = largest(R(magnitude(value(s.x2[k]))), R(magnitude(value(s.y2[k]))));
    return largest(motion, effect_size(sys, mode, piece.fx, k));
  };
  const R scale = motion_scale(sys, s);
  R h = step_from<T>(size(order), size(order - 1), scale, order, rtol, atol);
  if (has(sys, fx_pivot) && creeps(sys) && mode.pivot == 0) h = creep_step(sys, s, order, h);
  if (mode.contact == 0 || !has(sys, fx_peak)) return h;
  return peak_step(sys, piece.fx, order, h, R((R(atol) + R(rtol) * scale) * tolerance_share));
}

}  // namespace stickslip::inline STICKSLIP_ISA
