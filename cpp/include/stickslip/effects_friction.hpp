// Friction of a contact with effects, slipping or stuck, and its static limits, coefficient by coefficient.
#pragma once

#include "stickslip/effects.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
const Branch<T>& branch_in(const System<T>& sys, const Mode& mode) {
  return branch_of(sys, mode.contact);
}

// Kinetic magnitude R (with the Stribeck peak) of the argument u, coefficient k.
template <class T>
T kinetic_next(const System<T>& sys, const Mode& mode, EffectSeries<T>& fx, int k) {
  const Branch<T>& b = branch_in(sys, mode);
  T r = constant(mode.saturated ? b.saturated : b.c0, k);
  if (!mode.saturated) {
    r = r + b.c1 * fx.u[k];
    if (k > 0) fx.slope[k] = fx.u[k] * static_cast<double>(k);
    if (b.shape == Shape::exponentials) {
      fx.e1[k] = k == 0 ? b.a1 * exponential(b.k1 * fx.u[0]) : exponential_next(fx.slope, fx.e1, k) * b.k1;
      fx.e2[k] = k == 0 ? b.a2 * exponential(b.k2 * fx.u[0]) : exponential_next(fx.slope, fx.e2, k) * b.k2;
      r = r - fx.e1[k] - fx.e2[k];
    } else if (b.shape == Shape::rational) {
      fx.e2[k] = constant(T(1.0), k) + b.decay * fx.u[k];
      fx.e1[k] = k == 0 ? b.rational / fx.e2[0] : quotient_next(T(0.0), fx.e2, fx.e1, T(1.0) / fx.e2[0], k);
      r = r + fx.e1[k] + b.c2 * product(fx.u, fx.u, k);
    }
  }
  if (has(sys, fx_peak)) {  // dT e^(-(u/v_s)^2)
    const T over = T(1.0) / (sys.p[stribeck_peak_v_s] * sys.p[stribeck_peak_v_s]);
    fx.square[k] = product(fx.u, fx.u, k);
    if (k > 0) fx.peak_slope[k] = -(fx.square[k] * over) * static_cast<double>(k);
    fx.peak[k] = k == 0 ? sys.p[stribeck_peak_dT] * exponential(-(fx.square[0] * over))
                        : exponential_next(fx.peak_slope, fx.peak, k);
    r = r + fx.peak[k];
  }
  return r;
}

// Friction T of a slipping contact, coefficient k; on bristles this also extends z.
template <class T>
T slip_friction(const System<T>& sys, const Mode& mode, const Series<T>& s, EffectSeries<T>& fx, const T& t0, int k) {
  const Parameters<T>& p = sys.p;
  const double dir = mode.contact;
  fx.u[k] = has(sys, fx_memory) ? fx.w[k] * static_cast<double>(mode.w_sign) : fx.v[k] * dir;
  fx.magnitude[k] = kinetic_next(sys, mode, fx, k);
  const T* factor = friction_factor(sys, mode, s, fx, t0, k);
  fx.kinetic[k] = factor == nullptr ? fx.magnitude[k] : product(fx.magnitude, factor, k);
  if (!has(sys, fx_compliance)) return fx.kinetic[k] * dir;
  const T bristle = p[contact_compliance_k] * fx.z[k] + p[contact_compliance_c] * fx.v[k];
  fx.zv[k] = product(fx.z, fx.v, k) * dir;
  const auto pressed = greater(value(fx.kinetic[0]), Real<T>(0.0));  // lifted: the bristles are free
  const T over = T(1.0) / select(pressed, fx.kinetic[0], T(1.0));
  fx.ratio[k] = quotient_next(fx.zv[k], fx.kinetic, fx.ratio, over, k);
  const T grows = (fx.v[k] - p[contact_compliance_k] * fx.ratio[k]) * inverse<T>(k + 1);
  fx.z[k + 1] = select(pressed, grows, T(0.0));
  return bristle;
}

// Static limits of both directions, coefficient k.
template <class T>
void limits_next(const System<T>& sys, const State<T>& state, const T* factor, EffectSeries<T>& fx, int k) {
  const Parameters<T>& p = sys.p;
  T extra(0.0);
  if (has(sys, fx_peak)) extra = extra + constant(p[stribeck_peak_dT], k);
  if (has(sys, fx_aging)) {
    const T over = T(1.0) / p[static_aging_tau];
    fx.aging[k] = k == 0 ? p[static_aging_dT] * exponential(-(state.z[hidden_dwell] * over))
                         : -(fx.aging[k - 1] * over) * inverse<T>(k);
    extra = extra + constant(p[static_aging_dT], k) - fx.aging[k];
  }
  fx.e1[k] = constant(sys.minus.static_limit, k) + extra;
  fx.e2[k] = constant(sys.plus.static_limit, k) + extra;
  fx.limit_minus[k] = factor == nullptr ? fx.e1[k] : product(factor, fx.e1, k);
  fx.limit_plus[k] = factor == nullptr ? fx.e2[k] : product(factor, fx.e2, k);
}

// Friction of a stuck contact, T = -q.
template <class T>
T stick_friction(const System<T>& sys, const Series<T>& s, const EffectSeries<T>& fx, const T& force, int k) {
  const Parameters<T>& p = sys.p;
  T q = demand(sys.rig, s.x1[k], s.x2[k], s.y1[k], s.y2[k]) - force;
  if (has(sys, fx_ripple)) q = q + sys.rig.a1 * p[belt_speed_ripple_w] * fx.ripple_cos[k];
  if (has(sys, fx_droop)) {
    const T over = T(1.0) / p[belt_load_droop_tau];
    q = (q - sys.rig.a1 * fx.b[k] * over) / (T(1.0) + sys.rig.a1 * p[belt_load_droop_k] * over);
  }
  return -q;
}

}  // namespace stickslip::inline STICKSLIP_ISA
