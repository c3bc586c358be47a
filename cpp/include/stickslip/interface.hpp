// What crosses the border between the kernels (one build per instruction set) and the rest: plain data, no templates.
//
// Kernels never allocate and never call the standard library's containers, so that no inline function compiled for
// AVX can be merged into code that must run without it. This namespace is the same in every build.
#pragma once

#include <cstdint>

namespace stickslip_abi {

enum class RigKind : int { two_degree = 0, block_on_belt = 1 };
enum class LawKind : int { paper = 0, coulomb = 1, hyperbolic = 2 };
enum class Locator : int { henon = 0, bracket = 1 };

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
  sensor_nonlinearity_q,
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

// The state: x1 x2 y1 y2, then the hidden ones: memory w, bristle z, belt b, lagged reading m, dwell.
enum Hidden : int { hidden_w = 4, hidden_z = 5, hidden_b = 6, hidden_m = 7, hidden_dwell = 8, state_count = 9 };

enum class Outcome : int {
  finished = 0,
  chatter,
  not_finite,
  step_too_small,
  too_many_transitions,
  interrupted,
  too_many_steps
};

constexpr long most_steps = 5'000'000;  // of a trajectory, unless told otherwise

struct Transition {
  double t;
  int before, after;          // -1, 0, 1
  bool kink;                  // the contact mode stays; a branch saturates or an effect switches
  const double* state;        // state_count
  const double* derivatives;  // of (t, state) with respect to each seed: (1 + state_count) x seeds
};

// One trajectory to compute. Pointers are borrowed for the call.
struct Request {
  const Structure* structure;
  const double* parameters;  // parameter_count
  const double* initial;     // state_count
  double t_start, t_end;
  int contact;           // -1, 0, 1: the mode to start in; 2: found from the state
  const double* t_eval;  // increasing, within [t_start, t_end]; null: every step's end
  long n_eval;
  double rtol, atol;
  Locator locator;
  int n_seeds;
  const double* seeds;  // n_seeds x (parameter_count + state_count)
  long max_transitions, max_steps;
  int order;          // 0: from the tolerance
  double fixed_step;  // 0: from the tolerance
};

// Where results go. `sample` is called in time order, with the derivatives laid out as state x seeds.
struct Sink {
  void* context;
  void (*sample)(void*, double t, const double* state, const double* derivatives, int mode);
  void (*transition)(void*, const Transition&);
  bool (*interrupted)(void*);
};

// What a sweep can keep of each trajectory, one bit each.
enum Observable : std::uint32_t {
  ob_final = 1u << 0,
  ob_stick = 1u << 1,
  ob_counts = 1u << 2,  // transitions, releases, period and its spread
  ob_range = 1u << 3,
  ob_dissipated = 1u << 4,
  ob_points = 1u << 5  // states at the last releases
};

// One trajectory's results. Counted from `after` on.
struct SweepRow {
  double final_state[state_count];
  double t;
  double stick_time;
  double transitions, releases, slips;  // slips: releases from stick alone
  double first_release, last_release, interval_squares;
  double state_min[4], state_max[4];
  double dissipated;
  double steps;
  double outcome;
};
constexpr int max_sweep_points = 64;
constexpr int sweep_row_size = sizeof(SweepRow) / sizeof(double);

// Many trajectories of one structure. Member m takes `base` with value j of its row in slot `varied[j]` (parameters,
// then states). `take` hands out member numbers, negative when there are none left; `done` receives each result.
struct SweepRequest {
  const Structure* structure;
  const double* base;  // parameter_count + state_count
  const int* varied;   // n_varied
  int n_varied;
  const double* values;  // members x n_varied
  double t_end, after;
  double rtol, atol;
  std::uint32_t observe;
  int points;  // how many of the last releases to keep
  bool lanes;  // false: one at a time, the reference for the lanes
  long max_transitions, max_steps;
  void* context;
  long (*take)(void*);
  void (*done)(void*, long member, const SweepRow&, const double* points);  // points x (1 + 4): t and state, last first
};

struct Summary {
  Outcome outcome = Outcome::finished;
  double t = 0;
  long steps = 0, transitions = 0, kinks = 0;
  int contact = 0;
  double largest_switch = 0;  // largest |S| left at a located transition
  double dissipated = 0;
};

}  // namespace stickslip_abi
