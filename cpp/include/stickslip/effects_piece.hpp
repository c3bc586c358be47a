// A piece of a trajectory with effects: the whole vector field as series, its switching functions, its mode changes.
#pragma once

#include "stickslip/effects_friction.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// The belt's own speed V, coefficient k.
template <class T>
void belt_next(const System<T>& sys, EffectSeries<T>& fx, const T& t0, int k) {
  const Parameters<T>& p = sys.p;
  fx.belt[k] = constant(sys.rig.v_b, k);
  if (has(sys, fx_ripple)) {
    oscillation_next(T(p[belt_speed_ripple_a] * sys.rig.v_b), p[belt_speed_ripple_w], p[belt_speed_ripple_phi], t0, k,
                     fx.ripple, fx.ripple_cos);
    fx.belt[k] = fx.belt[k] + fx.ripple[k];
  }
  if (has(sys, fx_droop)) fx.belt[k] = fx.belt[k] + fx.b[k];
}

// With a creep speed the sign is tanh(y2/v_c) where |y2| < creep_reach v_c, and the sign itself beyond: there they differ
// by 1e-17.
constexpr double creep_reach = 20;
template <class T>
bool creeps(const System<T>& sys) {
  return lane(value(sys.p[pivot_dry_friction_v_c]), 0) > 0;  // lanes that differ in this do not meet
}

// Force of the pivot's friction on the angle body, coefficient k; not called where it is stuck.
template <class T>
T pivot_friction(const System<T>& sys, const Mode& mode, const Series<T>& s, EffectSeries<T>& fx, int k) {
  const T& f = sys.p[pivot_dry_friction_f];
  if (!creeps(sys) || mode.pivot != 0) return constant(f * static_cast<double>(-mode.pivot), k);
  const T a = s.y2[k] / sys.p[pivot_dry_friction_v_c];
  fx.creep_slope[k] = k == 0 ? a : a * static_cast<double>(k);
  if (k == 0) {
    const T e = exponential(a * 2.0);
    fx.creep[0] = (e - T(1.0)) / (e + T(1.0));
  } else {
    fx.creep[k] = rotation_next(fx.creep_slope, fx.creep_rest, k);
  }
  fx.creep_rest[k] = constant(T(1.0), k) - product(fx.creep, fx.creep, k);
  return -(f * fx.creep[k]);
}

// All series of the piece, `order` of them.
template <class T>
void expand_effects(const System<T>& sys, const Mode& mode, const State<T>& state, int order, Piece<T>& piece) {
  const Parameters<T>& p = sys.p;
  const Rig<T>& r = sys.rig;
  Series<T>& s = piece.s;
  EffectSeries<T>& fx = piece.fx;
  fx.w[0] = state.z[hidden_w];
  fx.z[0] = state.z[hidden_z];
  fx.b[0] = state.z[hidden_b];
  fx.m[0] = state.z[hidden_m];
  fx.lag_settles = false;
  for (int k = 0; k <= order; ++k) {
    const Real<T> over = inverse<T>(k + 1);
    belt_next(sys, fx, state.t, k);
    if (mode.contact == 0) s.x2[k] = fx.belt[k];
    fx.v[k] = s.x2[k] - fx.belt[k];
    T force = block_force(sys, mode, s, fx, state.t, k), leg = leg_force(sys, mode, s, fx, k);
    if (has(sys, fx_cubic2)) {
      fx.sum[k] = s.x1[k] + s.y1[k];
      const T both = p[spring_cubic_k2_k] * cube_next(fx.sum, fx.sum_square, k);
      force = force - both;
      leg = leg - both;
    }
    if (has(sys, fx_table)) {
      variable_next(sys, mode, s, fx, state.t, k);
      fx.table[k] = table_next(sys, mode, fx, k);
      if (sys.structure.table_place == TablePlace::block) force = force + fx.table[k];
      if (sys.structure.table_place == TablePlace::angle_body) leg = leg + fx.table[k];
    }
    if (mode.contact == 0) {
      fx.friction[k] = stick_friction(sys, s, fx, force, k);
      limits_next(sys, state, friction_factor(sys, mode, s, fx, state.t, k), fx, k);
      fx.w[k + 1] = T(0.0);
    } else {
      fx.friction[k] = slip_friction(sys, mode, s, fx, state.t, k);
      s.x2[k + 1] =
          -(r.kx * s.x1[k] + (bracket(r, s.x2[k], s.y1[k], s.y2[k]) + fx.friction[k] - force) * r.over_a1) * over;
      if (has(sys, fx_memory)) fx.w[k + 1] = (fx.v[k] - fx.w[k]) / p[friction_memory_tau] * over;
    }
    if (has(sys, fx_droop))
      fx.b[k + 1] = (p[belt_load_droop_k] * fx.friction[k] - fx.b[k]) / p[belt_load_droop_tau] * over;
    if (has(sys, fx_lag)) {
      const T reads = s.x1[k] + p[sensor_crosstalk_c] * s.y1[k];
      fx.reads[k] = reads;
      fx.m[k + 1] = (reads - fx.m[k]) / p[sensor_lag_tau] * over;
    }
    s.x1[k + 1] = s.x2[k] * over;
    s.y1[k + 1] = s.y2[k] * over;
    fx.pivot_force[k] = -(r.b3 * s.y1[k] + r.e12 * s.y2[k] + s.x1[k] + r.e1 * s.x2[k]) + leg;
    const bool free = r.two && !(has(sys, fx_pivot) && mode.pivot == 0 && !creeps(sys));
    T drive = fx.pivot_force[k];
    if (has(sys, fx_pivot) && free) drive = drive + pivot_friction(sys, mode, s, fx, k);
    s.y2[k + 1] = free ? drive * r.over_a2 * over : T(0.0);
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
