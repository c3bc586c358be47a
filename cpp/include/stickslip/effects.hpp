// The catalogue's terms as series: what each effect adds to the vector field, to the contact and to the belt.
//
// Equations as in docs/effects.md. The block feels -T; B and A are the extra forces on block and angle body, M =
// alpha1, Q = M kx x1 + e1 (x2 + y2) + s y1 - B:
//   slip   M x2' = -(Q + T)                          T = sgn(v) (factor) R(u), or k z + c v on bristles
//   stick  x2 = V(t),  T = -q,  q = (Q + M (r' - b/tau)) / (1 + M k/tau)
//   belt   V = v_b + r(t) + b,  r = v_b a sin(w t + phi),  tau b' = k T - b
#pragma once

#include <numbers>

#include "stickslip/piece.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
bool has(const System<T>& sys, Effect effect) {
  return (sys.structure.effects & effect) != 0;
}

// sin and cos of w t + phi, times an amplitude.
template <class T>
void oscillation_next(const T& amplitude, const T& w, const T& phi, const T& t0, int k, T* sin_k, T* cos_k) {
  if (k == 0) {
    sin_k[0] = amplitude * sine(w * t0 + phi);
    cos_k[0] = amplitude * cosine(w * t0 + phi);
  } else {
    sin_k[k] = w * cos_k[k - 1] * inverse<T>(k);
    cos_k[k] = -(w * sin_k[k - 1]) * inverse<T>(k);
  }
}

template <class T>
T constant(const T& c, int k) {
  return k == 0 ? c : T(0.0);
}

// (a a a)_k with the square kept.
template <class T>
T cube_next(const T* a, T* square, int k) {
  square[k] = product(a, a, k);
  return product(square, a, k);
}

// The tabulated curve g(variable), coefficient k.
template <class T>
T table_next(const System<T>& sys, const Mode& mode, EffectSeries<T>& fx, int k) {
  const int n = sys.structure.knots, i = mode.knot;
  const T* c = sys.table[i];
  if (i == 0 || i == n) return constant(c[0], k);
  T* d = fx.variable2;  // variable - left knot, then its powers
  d[k] = fx.variable[k] - constant(T(sys.structure.knot[i - 1]), k);
  T* square = fx.variable3;
  const T cubic = cube_next(d, square, k);
  return constant(c[0], k) + c[1] * d[k] + c[2] * square[k] + c[3] * cubic;
}

// Coefficient 0 or 1 of the time that the table is read at; with a period, the periods behind are taken off.
template <class T>
T table_time(const System<T>& sys, const Mode& mode, const T& t0, int k) {
  const double period = sys.structure.table_period;
  if (!(period > 0)) return k == 0 ? t0 : T(1.0);
  const double turn = period / (2 * std::numbers::pi);
  if (k == 1) return sys.p[tabulated_w] * turn;
  return (sys.p[tabulated_w] * t0 + sys.p[tabulated_phi]) * turn - mode.cycle * period;
}

template <class T>
void variable_next(const System<T>& sys, const Mode& mode, const Series<T>& s, EffectSeries<T>& fx, const T& t0,
                   int k) {
  switch (sys.structure.table_variable) {
    case TableVariable::x1: fx.variable[k] = s.x1[k]; break;
    case TableVariable::x2: fx.variable[k] = s.x2[k]; break;
    case TableVariable::y1: fx.variable[k] = s.y1[k]; break;
    case TableVariable::y2: fx.variable[k] = s.y2[k]; break;
    case TableVariable::v_w: fx.variable[k] = fx.v[k]; break;
    default: fx.variable[k] = k < 2 ? table_time(sys, mode, t0, k) : T(0.0);
  }
}

// Extra force on the block and on the angle body.
template <class T>
T block_force(const System<T>& sys, const Mode& mode, const Series<T>& s, EffectSeries<T>& fx, const T& t0, int k) {
  const Parameters<T>& p = sys.p;
  T f(0.0);
  if (has(sys, fx_viscous)) f = f - p[block_viscous_damping_c] * s.x2[k];
  if (has(sys, fx_quadratic)) {
    fx.x2_square[k] = product(s.x2, s.x2, k);
    f = f - p[block_quadratic_damping_c] * fx.x2_square[k] * static_cast<double>(mode.x2_sign);
  }
  if (has(sys, fx_cubic1)) f = f - p[spring_cubic_k1_k] * cube_next(s.x1, fx.x1_square, k);
  if (has(sys, fx_load)) f = f + constant(p[constant_load_f], k);
  if (has(sys, fx_forcing)) {
    oscillation_next(p[harmonic_forcing_a], p[harmonic_forcing_w], p[harmonic_forcing_phi], t0, k, fx.forcing,
                     fx.forcing_cos);
    f = f + fx.forcing[k];
  }
  return f;
}

template <class T>
T leg_force(const System<T>& sys, const Mode& mode, const Series<T>& s, EffectSeries<T>& fx, int k) {
  const Parameters<T>& p = sys.p;
  T f(0.0);
  if (has(sys, fx_cubic3)) f = f - p[spring_cubic_k3_k] * cube_next(s.y1, fx.y1_square, k);
  if (has(sys, fx_gap) && mode.gap != 0)
    f = f - p[spring_gap_k3_k] * (s.y1[k] - constant(p[spring_gap_k3_d] * static_cast<double>(mode.gap), k));
  return f;
}

// out = last (1 + series), coefficient k; `last` null stands for 1. Returns out.
template <class T>
const T* times_one_plus(const T* last, const T* series, T* out, int k) {
  out[k] = last == nullptr ? series[k] + constant(T(1.0), k) : product(last, series, k) + last[k];
  return out;
}

template <class T>
void seam_next(const System<T>& sys, const Series<T>& s, EffectSeries<T>& fx, const T& t0, int k) {
  const Parameters<T>& p = sys.p;
  const T turn = 6.283185307179586477 / p[belt_seam_L];
  if (k == 0) {
    const T angle = turn * (sys.rig.v_b * t0 - s.x1[0]) + p[belt_seam_phi];
    fx.seam[0] = p[belt_seam_a] * sine(angle);
    fx.seam_cos[0] = p[belt_seam_a] * cosine(angle);
    return;
  }
  fx.seam_slope[k] = turn * (constant(sys.rig.v_b, k - 1) - s.x1[k]) * static_cast<double>(k);
  fx.seam[k] = rotation_next(fx.seam_slope, fx.seam_cos, k);
  fx.seam_cos[k] = -rotation_next(fx.seam_slope, fx.seam, k);
}

// What multiplies friction, kinetic and static: normal force, drift, seam, table. Null if nothing does.
template <class T>
const T* friction_factor(const System<T>& sys, const Mode& mode, const Series<T>& s, EffectSeries<T>& fx, const T& t0,
                         int k) {
  const Parameters<T>& p = sys.p;
  const T* last = nullptr;
  if (has(sys, fx_normal)) {
    const T rise =
        (p[normal_force_feedback_beta2] * s.y1[k] + p[normal_force_feedback_eta2] * s.y2[k]) / sys.minus.static_limit;
    fx.normal[k] = rise + constant(T(1.0), k);
    fx.factor[0][k] = mode.lifted ? T(0.0) : fx.normal[k];
    last = fx.factor[0];
  }
  if (has(sys, fx_drift)) {
    fx.drift[k] = k == 0 ? p[friction_drift_r] * t0 : constant(p[friction_drift_r], k - 1);
    last = times_one_plus(last, fx.drift, fx.factor[1], k);
  }
  if (has(sys, fx_seam)) {
    seam_next(sys, s, fx, t0, k);
    last = times_one_plus(last, fx.seam, fx.factor[2], k);
  }
  if (has(sys, fx_table) && sys.structure.table_place == TablePlace::contact)
    last = times_one_plus(last, fx.table, fx.factor[3], k);
  return last;
}

}  // namespace stickslip::inline STICKSLIP_ISA
