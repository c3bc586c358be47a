#include <string>

#include "support.hpp"

using namespace support;

namespace {

constexpr int order = 24;

// The reference rig with a number for every effect; which of them act is set apart.
Setup all_effects() {
  Setup s = reference_rig();
  auto& p = s.p;
  p[block_viscous_damping_c] = 0.3, p[block_quadratic_damping_c] = 0.7, p[spring_cubic_k1_k] = 2.0;
  p[spring_cubic_k2_k] = 1.5, p[spring_cubic_k3_k] = 3.0, p[spring_gap_k3_k] = 4.0, p[spring_gap_k3_d] = 0.05;
  p[constant_load_f] = 0.4, p[harmonic_forcing_a] = 0.6, p[harmonic_forcing_w] = 1.7, p[harmonic_forcing_phi] = 0.4;
  p[pivot_dry_friction_f] = 0.2, p[normal_force_feedback_beta2] = 0.8, p[normal_force_feedback_eta2] = 0.5;
  p[stribeck_peak_dT] = 0.7, p[stribeck_peak_v_s] = 0.08, p[static_aging_dT] = 0.5, p[static_aging_tau] = 2.0;
  p[friction_memory_tau] = 0.3, p[friction_drift_r] = 0.02, p[belt_seam_a] = 0.1, p[belt_seam_L] = 1.5;
  p[belt_seam_phi] = 0.9, p[contact_compliance_k] = 300, p[contact_compliance_c] = 2, p[belt_speed_ripple_a] = 0.15;
  p[belt_speed_ripple_w] = 2.3, p[belt_speed_ripple_phi] = 1.1, p[belt_load_droop_k] = 0.004;
  p[belt_load_droop_tau] = 0.8, p[sensor_lag_tau] = 0.2, p[sensor_crosstalk_c] = 0.1;
  s.structure.knots = 3;
  for (std::size_t i = 0; i < 3; ++i) {
    s.structure.knot[i] = -1.0 + static_cast<double>(i);
    p[slot_count + i] = 0.3 * std::cos(2.0 * static_cast<double>(i));
  }
  s.z = {0.12, 0.0, -0.2, 0.15, 0.0, 0.003, -0.01, 0.1, 0.7};
  return s;
}

// The series of a piece at one time: states, their slopes, and the friction it was built with.
struct Point {
  double t, z[8], slope[8], friction, limit_minus, limit_plus;
};

// The equations of the catalogue, written out at one point.
struct Equations {
  const Setup& s;
  const System<double>& sys;
  const Mode& mode;
  const Point& at;

  bool acts(Effect e) const { return (s.structure.effects & e) != 0; }
  double x1() const { return at.z[0]; }
  double x2() const { return at.z[1]; }
  double y1() const { return at.z[2]; }
  double y2() const { return at.z[3]; }
  double ripple() const {
    const auto& p = s.p;
    return acts(fx_ripple) ? p[belt_speed_ripple_a] * std::sin(p[belt_speed_ripple_w] * at.t + p[belt_speed_ripple_phi])
                           : 0;
  }
  double belt() const { return s.p[belt_speed] * (1 + ripple()) + (acts(fx_droop) ? at.z[hidden_b] : 0); }
  double v() const { return x2() - belt(); }
  double table(TablePlace place) const {
    if (!acts(fx_table) || s.structure.table_place != place) return 0;
    const double of[] = {x1(), x2(), y1(), y2(), v(), at.t};
    const double x = of[static_cast<int>(s.structure.table_variable)];
    const double* c = sys.table[mode.knot];
    if (mode.knot == 0 || mode.knot == s.structure.knots) return c[0];
    const double d = x - s.structure.knot[mode.knot - 1];
    return c[0] + d * (c[1] + d * (c[2] + d * c[3]));
  }
  double factor() const {
    const auto& p = s.p;
    double f = 1;
    if (acts(fx_normal))
      f *= 1 + (p[normal_force_feedback_beta2] * y1() + p[normal_force_feedback_eta2] * y2()) / p[T_s_minus];
    if (acts(fx_drift)) f *= 1 + p[friction_drift_r] * at.t;
    if (acts(fx_seam))
      f *= 1 + p[belt_seam_a] * std::sin(2 * M_PI * (p[belt_speed] * at.t - x1()) / p[belt_seam_L] + p[belt_seam_phi]);
    return f * (1 + table(TablePlace::contact));
  }
  double kinetic() const {
    const double u = std::abs(acts(fx_memory) ? at.z[hidden_w] : v()), v_s = s.p[stribeck_peak_v_s];
    const double peak = acts(fx_peak) ? s.p[stribeck_peak_dT] * std::exp(-u * u / (v_s * v_s)) : 0;
    return factor() * (magnitude(branch_of(sys, mode.contact), u) + peak);
  }
  double friction() const {
    if (!acts(fx_compliance)) return mode.contact * kinetic();
    return s.p[contact_compliance_k] * at.z[hidden_z] + s.p[contact_compliance_c] * v();
  }
  double limit(double at_rest) const {
    const auto& p = s.p;
    double r = at_rest;
    if (acts(fx_peak)) r += p[stribeck_peak_dT];
    if (acts(fx_aging)) r += p[static_aging_dT] * (1 - std::exp(-(s.z[hidden_dwell] + at.t) / p[static_aging_tau]));
    return factor() * r;
  }
  double both() const { return acts(fx_cubic2) ? -s.p[spring_cubic_k2_k] * std::pow(x1() + y1(), 3) : 0; }
  double block_force() const {
    const auto& p = s.p;
    double f = both() + table(TablePlace::block);
    if (acts(fx_viscous)) f -= p[block_viscous_damping_c] * x2();
    if (acts(fx_quadratic)) f -= p[block_quadratic_damping_c] * x2() * std::abs(x2());
    if (acts(fx_cubic1)) f -= p[spring_cubic_k1_k] * std::pow(x1(), 3);
    if (acts(fx_load)) f += p[constant_load_f];
    if (acts(fx_forcing)) f += p[harmonic_forcing_a] * std::sin(p[harmonic_forcing_w] * at.t + p[harmonic_forcing_phi]);
    return f;
  }
  double leg_force() const {
    const auto& p = s.p;
    double f = both() + table(TablePlace::angle_body);
    if (acts(fx_cubic3)) f -= p[spring_cubic_k3_k] * std::pow(y1(), 3);
    if (acts(fx_gap) && std::abs(y1()) > p[spring_gap_k3_d])
      f -= p[spring_gap_k3_k] * (y1() - std::copysign(p[spring_gap_k3_d], y1()));
    if (acts(fx_pivot)) f -= std::copysign(p[pivot_dry_friction_f], y2());
    return f;
  }
};

Point point_of(Piece<double>& piece, double t) {
  Point at{};
  at.t = t;
  for (int i = 0; i < 8; ++i) {
    at.z[i] = evaluate(state_series(piece, i), order, t);
    at.slope[i] = evaluate_slope(state_series(piece, i), order, t);
  }
  at.friction = evaluate(piece.fx.friction, order, t);
  at.limit_minus = evaluate(piece.fx.limit_minus, order, t);
  at.limit_plus = evaluate(piece.fx.limit_plus, order, t);
  return at;
}

void check_equations(const Equations& e) {
  const auto near = [](const char* what, double got, double expected) {
    INFO(std::string(what), ": ", got, " instead of ", expected);
    CHECK(close(got, expected, 2e-10));
  };
  const auto& p = e.s.p;
  const auto& at = e.at;
  near("x1'", at.slope[0], e.x2());
  near("y1'", at.slope[2], e.y2());
  // the block: alpha1 (x2' + x1) = -(eta1 (x2 + y2) + s y1 + T) + forces
  near("x2'", p[alpha1] * (at.slope[1] + e.x1()),
       -(p[eta1] * (e.x2() + e.y2()) + p[coupling] * e.y1() + at.friction) + e.block_force());
  near("y2'", p[alpha2] * at.slope[3],
       -p[beta3] * e.y1() - p[eta12] * e.y2() - e.x1() - p[eta1] * e.x2() + e.leg_force());
  if (e.acts(fx_droop))
    near("belt droop", p[belt_load_droop_tau] * at.slope[hidden_b],
         p[belt_load_droop_k] * at.friction - at.z[hidden_b]);
  if (e.acts(fx_lag))
    near("sensor lag", p[sensor_lag_tau] * at.slope[hidden_m],
         e.x1() + p[sensor_crosstalk_c] * e.y1() - at.z[hidden_m]);
  if (e.mode.contact == 0) {
    near("v_w in stick", e.v(), 0.0);
    near("limit of T_-", at.limit_minus, e.limit(p[T_s_minus]));
    near("limit of T_+", at.limit_plus, e.limit(p[T_s_plus]));
    return;
  }
  near("T", at.friction, e.friction());
  if (e.acts(fx_memory)) near("memory", p[friction_memory_tau] * at.slope[hidden_w], e.v() - at.z[hidden_w]);
  if (e.acts(fx_compliance))
    near("bristles", at.slope[hidden_z],
         e.v() - p[contact_compliance_k] * std::abs(e.v()) * at.z[hidden_z] / e.kinetic());
}

void check_effects(Setup setup, std::uint32_t effects, int contact) {
  setup.structure.effects = effects;
  System<double> sys;
  prepare(setup, sys);
  static Piece<double> piece;
  State<double> s{};
  std::copy(setup.z.begin(), setup.z.end(), s.z);
  Mode mode;
  Side on[watch_count] = {};
  const double u = 0.15;
  Point start{};
  std::copy(s.z, s.z + 8, start.z);
  s.z[1] = Equations{setup, sys, mode, start}.belt() + contact * u;
  s.z[hidden_w] = contact * 0.1;
  set_effect_modes(sys, s, mode, on, piece);
  mode.contact = contact;
  mode.w_sign = contact;
  for (int i = 0; i < 4; ++i) state_series(piece, i)[0] = s.z[i];
  expand_effects(sys, mode, s, order, piece);
  for (const double t : {0.0, 0.002, 0.006}) {
    const Point at = point_of(piece, t);
    INFO("effects ", effects, " contact ", contact, " t ", t);
    check_equations({setup, sys, mode, at});
  }
}

}  // namespace

TEST_CASE("effects: each alone satisfies its equation in stick and in slip either way") {
  const Setup setup = all_effects();
  for (int bit = 0; bit < 19; ++bit) {
    for (const int contact : {-1, 0, 1}) {
      if (contact == 0 && (1u << bit) == fx_compliance) continue;  // bristles know no rigid stick
      check_effects(setup, 1u << bit, contact);
    }
  }
}

TEST_CASE("effects: any of them together satisfy their equations under every law") {
  std::mt19937 random(11);
  for (int n = 0; n < 300; ++n) {
    Setup setup = all_effects();
    setup.structure.law = static_cast<LawKind>(n % 3);
    setup.p[static_minus] = 5.94;  // the static limit of T_- in every law
    setup.p[scale_minus] = 5.94 - setup.p[constant_minus];
    setup.structure.table_place = static_cast<TablePlace>(random() % 3);
    setup.structure.table_variable = static_cast<TableVariable>(random() % 6);
    const auto effects = static_cast<std::uint32_t>(random() % (1u << 20));
    for (const int contact : {-1, 0, 1}) {
      if (contact == 0 && ((effects & fx_compliance) != 0 || setup.structure.law != LawKind::paper)) continue;
      check_effects(setup, effects, contact);
    }
  }
}

TEST_CASE("effects: a table of every variable in every place satisfies its equation") {
  for (const auto place : {TablePlace::block, TablePlace::angle_body, TablePlace::contact}) {
    for (int variable = 0; variable < 6; ++variable) {
      Setup setup = all_effects();
      setup.structure.table_place = place;
      setup.structure.table_variable = static_cast<TableVariable>(variable);
      for (const int contact : {-1, 0, 1}) check_effects(setup, fx_table, contact);
    }
  }
}
