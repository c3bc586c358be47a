#include <string>

#include "support.hpp"

using namespace support;

namespace {

constexpr int order = 24;

// Those whose equations stand below. A new effect is held to the formula of its Python file (tests/test_acts.py), and may
// be written out here too.
constexpr std::uint32_t tabulated = effect("tabulated") | effect("second_tabulated");
constexpr std::uint32_t written_out =
    effect("block_viscous_damping") | effect("block_quadratic_damping") | effect("spring_cubic_k1") |
    effect("spring_cubic_k2") | effect("spring_cubic_k3") | effect("spring_gap_k3") | effect("constant_load") |
    effect("harmonic_forcing") | effect("pivot_dry_friction") | effect("normal_force_feedback") |
    effect("stribeck_peak") | effect("static_aging") | effect("friction_memory") | effect("friction_drift") |
    effect("belt_seam") | effect("contact_compliance") | effect("belt_speed_ripple") | effect("belt_load_droop") |
    effect("sensor_lag") | tabulated;

// The reference rig with a number for every effect; which of them act is set apart.
Setup all_effects() {
  Setup s = reference_rig();
  auto& p = s.p;
  p[slot("block_viscous_damping.c")] = 0.3, p[slot("block_quadratic_damping.c")] = 0.7,
  p[slot("spring_cubic_k1.k")] = 2.0;
  p[slot("spring_cubic_k2.k")] = 1.5, p[slot("spring_cubic_k3.k")] = 3.0, p[slot("spring_gap_k3.k")] = 4.0,
  p[slot("spring_gap_k3.d")] = 0.05;
  p[slot("constant_load.f")] = 0.4, p[slot("harmonic_forcing.a")] = 0.6, p[slot("harmonic_forcing.w")] = 1.7,
  p[slot("harmonic_forcing.phi")] = 0.4;
  p[slot("pivot_dry_friction.f")] = 0.2, p[slot("normal_force_feedback.beta2")] = 0.8,
  p[slot("normal_force_feedback.eta2")] = 0.5;
  p[slot("stribeck_peak.dT")] = 0.7, p[slot("stribeck_peak.v_s")] = 0.08, p[slot("static_aging.dT")] = 0.5,
  p[slot("static_aging.tau")] = 2.0;
  p[slot("friction_memory.tau")] = 0.3, p[slot("friction_drift.r")] = 0.02, p[slot("belt_seam.a")] = 0.1,
  p[slot("belt_seam.L")] = 1.5;
  p[slot("belt_seam.phi")] = 0.9, p[slot("contact_compliance.k")] = 300, p[slot("contact_compliance.c")] = 2,
  p[slot("belt_speed_ripple.a")] = 0.15;
  p[slot("belt_speed_ripple.w")] = 2.3, p[slot("belt_speed_ripple.phi")] = 1.1, p[slot("belt_load_droop.k")] = 0.004;
  p[slot("belt_load_droop.tau")] = 0.8, p[slot("sensor_lag.tau")] = 0.2, p[slot("sensor_crosstalk.c")] = 0.1;
  for (auto& table : s.structure.table) table.knots = 3;
  for (std::size_t i = 0; i < 3; ++i) {
    s.structure.table[0].knot[i] = -1.0 + static_cast<double>(i);
    s.structure.table[1].knot[i] = -1.2 + 1.1 * static_cast<double>(i);
    p[slot_count + i] = 0.3 * std::cos(2.0 * static_cast<double>(i));
    p[slot_count + max_knots + i] = 0.2 * std::sin(1.0 + 2.0 * static_cast<double>(i));
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

  bool acts(std::uint32_t e) const { return (s.structure.effects & e) != 0; }
  double x1() const { return at.z[0]; }
  double x2() const { return at.z[1]; }
  double y1() const { return at.z[2]; }
  double y2() const { return at.z[3]; }
  double ripple() const {
    const auto& p = s.p;
    return acts(effect("belt_speed_ripple"))
               ? p[slot("belt_speed_ripple.a")] *
                     std::sin(p[slot("belt_speed_ripple.w")] * at.t + p[slot("belt_speed_ripple.phi")])
               : 0;
  }
  double belt() const {
    return s.p[belt_speed] * (1 + ripple()) + (acts(effect("belt_load_droop")) ? at.z[state("b")] : 0);
  }
  double v() const { return x2() - belt(); }
  template <class E>
  double table(TablePlace place) const {
    const Table& own = s.structure.table[E::table];
    if (!acts(bit_of<E>) || own.place != place) return 0;
    const double of[] = {x1(), x2(), y1(), y2(), v(), at.t};
    const double x = of[static_cast<int>(own.variable)];
    const int knot = mode.side[surface_of<E>];
    const double* c = sys.table[E::table][knot];
    if (knot == 0 || knot == own.knots) return c[0];
    const double d = x - own.knot[knot - 1];
    return c[0] + d * (c[1] + d * (c[2] + d * c[3]));
  }
  double tables(TablePlace place) const { return table<Tabulated>(place) + table<SecondTabulated>(place); }
  double factor() const {
    const auto& p = s.p;
    double f = 1;
    if (acts(effect("normal_force_feedback")))
      f *= 1 + (p[slot("normal_force_feedback.beta2")] * y1() + p[slot("normal_force_feedback.eta2")] * y2()) /
                   p[slot("paper.T_s_minus")];
    if (acts(effect("friction_drift"))) f *= 1 + p[slot("friction_drift.r")] * at.t;
    if (acts(effect("belt_seam")))
      f *= 1 + p[slot("belt_seam.a")] * std::sin(2 * M_PI * (p[belt_speed] * at.t - x1()) / p[slot("belt_seam.L")] +
                                                 p[slot("belt_seam.phi")]);
    return f * (1 + table<Tabulated>(TablePlace::contact)) * (1 + table<SecondTabulated>(TablePlace::contact));
  }
  double kinetic() const {
    const double u = std::abs(acts(effect("friction_memory")) ? at.z[state("w")] : v()),
                 v_s = s.p[slot("stribeck_peak.v_s")];
    const double peak =
        acts(effect("stribeck_peak")) ? s.p[slot("stribeck_peak.dT")] * std::exp(-u * u / (v_s * v_s)) : 0;
    return factor() * (magnitude(branch_of(sys, mode.contact), u) + peak);
  }
  double friction() const {
    if (!acts(effect("contact_compliance"))) return mode.contact * kinetic();
    return s.p[slot("contact_compliance.k")] * at.z[state("z")] + s.p[slot("contact_compliance.c")] * v();
  }
  double limit(double at_rest) const {
    const auto& p = s.p;
    double r = at_rest;
    if (acts(effect("stribeck_peak"))) r += p[slot("stribeck_peak.dT")];
    if (acts(effect("static_aging")))
      r += p[slot("static_aging.dT")] * (1 - std::exp(-(s.z[state("dwell")] + at.t) / p[slot("static_aging.tau")]));
    return factor() * r;
  }
  double both() const {
    return acts(effect("spring_cubic_k2")) ? -s.p[slot("spring_cubic_k2.k")] * std::pow(x1() + y1(), 3) : 0;
  }
  double block_force() const {
    const auto& p = s.p;
    double f = both() + tables(TablePlace::block);
    if (acts(effect("block_viscous_damping"))) f -= p[slot("block_viscous_damping.c")] * x2();
    if (acts(effect("block_quadratic_damping"))) f -= p[slot("block_quadratic_damping.c")] * x2() * std::abs(x2());
    if (acts(effect("spring_cubic_k1"))) f -= p[slot("spring_cubic_k1.k")] * std::pow(x1(), 3);
    if (acts(effect("constant_load"))) f += p[slot("constant_load.f")];
    if (acts(effect("harmonic_forcing")))
      f += p[slot("harmonic_forcing.a")] *
           std::sin(p[slot("harmonic_forcing.w")] * at.t + p[slot("harmonic_forcing.phi")]);
    return f;
  }
  double leg_force() const {
    const auto& p = s.p;
    double f = both() + tables(TablePlace::angle_body);
    if (acts(effect("spring_cubic_k3"))) f -= p[slot("spring_cubic_k3.k")] * std::pow(y1(), 3);
    if (acts(effect("spring_gap_k3")) && std::abs(y1()) > p[slot("spring_gap_k3.d")])
      f -= p[slot("spring_gap_k3.k")] * (y1() - std::copysign(p[slot("spring_gap_k3.d")], y1()));
    if (acts(effect("pivot_dry_friction"))) f -= std::copysign(p[slot("pivot_dry_friction.f")], y2());
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
  if (e.acts(effect("belt_load_droop")))
    near("belt droop", p[slot("belt_load_droop.tau")] * at.slope[state("b")],
         p[slot("belt_load_droop.k")] * at.friction - at.z[state("b")]);
  if (e.acts(effect("sensor_lag")))
    near("sensor lag", p[slot("sensor_lag.tau")] * at.slope[state("m")],
         e.x1() + p[slot("sensor_crosstalk.c")] * e.y1() - at.z[state("m")]);
  if (e.mode.contact == 0) {
    near("v_w in stick", e.v(), 0.0);
    near("limit of T_-", at.limit_minus, e.limit(p[slot("paper.T_s_minus")]));
    near("limit of T_+", at.limit_plus, e.limit(p[slot("paper.T_s_plus")]));
    return;
  }
  near("T", at.friction, e.friction());
  if (e.acts(effect("friction_memory")))
    near("memory", p[slot("friction_memory.tau")] * at.slope[state("w")], e.v() - at.z[state("w")]);
  if (e.acts(effect("contact_compliance")))
    near("bristles", at.slope[state("z")],
         e.v() - p[slot("contact_compliance.k")] * std::abs(e.v()) * at.z[state("z")] / e.kinetic());
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
  s.z[state("w")] = contact * 0.1;
  set_effect_modes(sys, s, mode, on, piece);
  mode.contact = contact;
  mode.side[surface_of<FrictionMemory>] = contact;
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
  for (int bit = 0; bit < Effects::size; ++bit) {
    const std::uint32_t one = (1u << bit) & written_out & ~tabulated;
    if (one == 0) continue;
    for (const int contact : {-1, 0, 1}) {
      if (contact == 0 && one == effect("contact_compliance")) continue;  // bristles know no rigid stick
      check_effects(setup, one, contact);
    }
  }
}

TEST_CASE("effects: any of them together satisfy their equations under every law") {
  std::mt19937 random(11);
  for (int n = 0; n < 300; ++n) {
    Setup setup = all_effects();
    setup.structure.law = std::array{law("paper"), law("coulomb"), law("hyperbolic")}[static_cast<std::size_t>(n % 3)];
    setup.p[slot("coulomb.static_minus")] = 5.94;  // the static limit of T_- in every law
    setup.p[slot("hyperbolic.scale_minus")] = 5.94 - setup.p[slot("hyperbolic.constant_minus")];
    for (auto& table : setup.structure.table) {
      table.place = static_cast<TablePlace>(random() % 3);
      table.variable = static_cast<TableVariable>(random() % 6);
    }
    const auto effects = static_cast<std::uint32_t>(random()) & written_out;
    for (const int contact : {-1, 0, 1}) {
      if (contact == 0 && ((effects & effect("contact_compliance")) != 0 || setup.structure.law != law("paper")))
        continue;
      check_effects(setup, effects, contact);
    }
  }
}

TEST_CASE("effects: a table of every variable in every place satisfies its equation") {
  for (const auto place : {TablePlace::block, TablePlace::angle_body, TablePlace::contact}) {
    for (int variable = 0; variable < 6; ++variable) {
      Setup setup = all_effects();
      for (auto& table : setup.structure.table) {
        table.place = place;
        table.variable = static_cast<TableVariable>(variable);
      }
      for (const std::uint32_t which : {effect("tabulated"), effect("second_tabulated"), tabulated})
        for (const int contact : {-1, 0, 1}) check_effects(setup, which, contact);
    }
  }
}
