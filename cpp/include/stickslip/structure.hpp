// A model as plain data: its numbers in one flat vector, and what they are the numbers of.
#pragma once

#include <cstdint>

namespace stickslip_abi {

enum class RigKind : int { two_degree = 0, block_on_belt = 1 };
enum class LawKind : int { paper = 0, coulomb = 1, hyperbolic = 2 };

// Every number a model can hold, in one flat vector. Laws and rigs share slots only where they share meaning.
enum Slot : int {
  // rig (2.1); of the 1-DOF block: mass = alpha1, damping = eta1, stiffness of its own
  alpha1,
  alpha2,
  beta3,
  eta1,
  eta12,
  coupling,
  stiffness,
  belt_speed,
  // the paper's law (4.1), (4.2)
  T_s_minus,
  A1,
  A2,
  t1,
  t2,
  v_w_min,
  T_min_minus,
  T_s_plus,
  T_min_plus,
  v_w_max,
  // Coulomb
  static_minus,
  kinetic_minus,
  static_plus,
  kinetic_plus,
  // hyperbolic
  scale_minus,
  decay_minus,
  constant_minus,
  quadratic_minus,
  scale_plus,
  decay_plus,
  constant_plus,
  quadratic_plus,
  // effects, in the order of the catalogue
  block_viscous_damping_c,
  block_quadratic_damping_c,
  spring_cubic_k1_k,
  spring_cubic_k2_k,
  spring_cubic_k3_k,
  spring_gap_k3_k,
  spring_gap_k3_d,
  constant_load_f,
  harmonic_forcing_a,
  harmonic_forcing_w,
  harmonic_forcing_phi,
  pivot_dry_friction_f,
  pivot_dry_friction_v_c,
  normal_force_feedback_beta2,
  normal_force_feedback_eta2,
  stribeck_peak_dT,
  stribeck_peak_v_s,
  static_aging_dT,
  static_aging_tau,
  friction_memory_tau,
  friction_drift_r,
  belt_seam_a,
  belt_seam_L,
  belt_seam_phi,
  contact_compliance_k,
  contact_compliance_c,
  belt_speed_ripple_a,
  belt_speed_ripple_w,
  belt_speed_ripple_phi,
  belt_load_droop_k,
  belt_load_droop_tau,
  sensor_lag_tau,
  sensor_crosstalk_c,
  tabulated_w,  // of a table that repeats in time: it is read at (w t + phi) period / 2 pi
  tabulated_phi,
  slot_count
};

// Effects that change the trajectory (and the sensor lag, a hidden state that rides along); one bit each.
enum Effect : std::uint32_t {
  fx_viscous = 1u << 0,
  fx_quadratic = 1u << 1,
  fx_cubic1 = 1u << 2,
  fx_cubic2 = 1u << 3,
  fx_cubic3 = 1u << 4,
  fx_gap = 1u << 5,
  fx_load = 1u << 6,
  fx_forcing = 1u << 7,
  fx_pivot = 1u << 8,
  fx_normal = 1u << 9,
  fx_peak = 1u << 10,
  fx_aging = 1u << 11,
  fx_memory = 1u << 12,
  fx_drift = 1u << 13,
  fx_seam = 1u << 14,
  fx_compliance = 1u << 15,
  fx_ripple = 1u << 16,
  fx_droop = 1u << 17,
  fx_lag = 1u << 18,
  fx_table = 1u << 19
};

// Where a tabulated term acts and on what it depends.
enum class TablePlace : int { block = 0, angle_body = 1, contact = 2 };
enum class TableVariable : int { x1 = 0, x2 = 1, y1 = 2, y2 = 3, v_w = 4, t = 5 };
constexpr int max_knots = 24;

struct Structure {
  RigKind rig = RigKind::two_degree;
  LawKind law = LawKind::paper;
  std::uint32_t effects = 0;
  TablePlace table_place = TablePlace::block;
  TableVariable table_variable = TableVariable::x1;
  double table_period = 0;  // of t-phase; 0: none
  int knots = 0;            // >= 2 with fx_table; the values at the knots are the slots after slot_count
  double knot[max_knots] = {};
};

constexpr int parameter_count = slot_count + max_knots;

}  // namespace stickslip_abi
