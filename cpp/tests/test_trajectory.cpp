#include "support.hpp"

using namespace support;

namespace {

Setup with_effects() {
  Setup s = reference_rig();
  s.structure.effects = effect("harmonic_forcing") | effect("spring_cubic_k1") | effect("belt_speed_ripple") |
                        effect("spring_gap_k3") | effect("stribeck_peak");
  s.p[slot("harmonic_forcing.a")] = 0.3, s.p[slot("harmonic_forcing.w")] = 1.7, s.p[slot("spring_cubic_k1.k")] = 1.0;
  s.p[slot("belt_speed_ripple.a")] = 0.05, s.p[slot("belt_speed_ripple.w")] = 2.0, s.p[slot("spring_gap_k3.k")] = 0.5;
  s.p[slot("spring_gap_k3.d")] = 0.05, s.p[slot("stribeck_peak.dT")] = 0.2, s.p[slot("stribeck_peak.v_s")] = 0.05;
  return s;
}

Setup with_law(int kind) {
  Setup s = reference_rig();
  s.structure.law = kind;
  return s;
}

std::vector<Setup> setups() {
  Setup backwards = reference_rig();
  backwards.p[belt_speed] = -0.1;
  return {
      reference_rig(), backwards, with_law(law("coulomb")), with_law(law("hyperbolic")), block_on_belt(1.0, 0.5, 0.2),
      with_effects()};
}

template <class A, class B>
void check_same(const Run<A>& a, const Run<B>& b, double tolerance) {
  const auto real = [](const auto& x) { return static_cast<double>(value(x)); };
  CHECK(a.summary.outcome == Outcome::finished);
  CHECK(b.summary.outcome == Outcome::finished);
  REQUIRE(a.changes.size() == b.changes.size());
  CHECK(a.changes.size() > 4);
  for (std::size_t i = 0; i < a.changes.size(); ++i) {
    CHECK(a.changes[i].before == b.changes[i].before);
    CHECK(a.changes[i].after == b.changes[i].after);
    CHECK(a.changes[i].kink == b.changes[i].kink);
    CHECK(close(real(a.changes[i].t), real(b.changes[i].t), tolerance));
    for (int k = 0; k < 4; ++k) CHECK(close(real(a.changes[i].z[k]), real(b.changes[i].z[k]), tolerance));
  }
  for (int k = 0; k < 4; ++k) CHECK(close(real(a.end.z[k]), real(b.end.z[k]), tolerance));
}

// Times of all transitions and the states at them, as functions of one varied number.
template <class Vary>
void check_seed(const Setup& setup, double t_end, const Vary& vary, double tolerance) {
  const auto seeded = run<Dual<4>>(setup, t_end, 1e-13, [&](auto& p, auto& s) {
    Dual<4> d(0.0);
    d.set_derivative(2, 1.0);
    vary(p, s, d);
  });
  const long double h = 1e-5L;
  std::vector<Run<long double>> moved;
  for (const long double shift : {-2 * h, -h, h, 2 * h})
    moved.push_back(run<long double>(setup, t_end, 1e-17, [&](auto& p, auto& s) { vary(p, s, shift); }));
  for (const auto& m : moved) REQUIRE(m.changes.size() == seeded.changes.size());
  const auto slope = [&](auto&& get) {
    return static_cast<double>((8 * (get(moved[2]) - get(moved[1])) - (get(moved[3]) - get(moved[0]))) / (12 * h));
  };
  for (std::size_t i = 0; i < seeded.changes.size(); ++i) {
    const double expected = slope([&](const auto& r) { return r.changes[i].t; });
    INFO("transition ", i, ": ", seeded.changes[i].t.derivative(2), " expected ", expected);
    CHECK(close(seeded.changes[i].t.derivative(2), expected, tolerance));
    for (int k = 0; k < 4; ++k)
      CHECK(close(seeded.changes[i].z[k].derivative(2), slope([&](const auto& r) { return r.changes[i].z[k]; }),
                  tolerance));
  }
  for (int k = 0; k < 4; ++k)
    CHECK(close(seeded.end.z[k].derivative(2), slope([&](const auto& r) { return r.end.z[k]; }), tolerance));
}

template <class T>
void check_coulomb(double tolerance) {
  const auto r = run<T>(block_on_belt(1.0, 0.5, 0.2), 40.0, 1e-15);
  // stick time 2 A/v = 5, slip time 2 (pi - atan(A/v)), A = F_s - F_k, re-stick at 2 F_k - F_s = 0
  const long double v_b = 0.2, stick = 1 / v_b, slip = 2 * (std::acos(-1.0L) - std::atan(0.5L / v_b));
  REQUIRE(r.changes.size() == 8);
  for (std::size_t i = 0; i < r.changes.size(); ++i) {
    const long double before = i == 0 ? 0.0L : static_cast<long double>(value(r.changes[i - 1].t));
    const long double lasted = static_cast<long double>(value(r.changes[i].t)) - before;
    CHECK(std::abs(static_cast<double>(lasted - (i % 2 == 0 ? stick : slip))) < tolerance);
    CHECK(close(static_cast<double>(value(r.changes[i].z[0])), i % 2 == 0 ? 1.0 : 0.0, tolerance));
  }
}

}  // namespace

TEST_CASE("trajectory: double, long double and dual numbers run the same motion") {
  for (const Setup& setup : setups()) {
    const auto plain = run<double>(setup, 60.0, 1e-12);
    check_same(plain, run<long double>(setup, 60.0, 1e-12), 2e-10);
    check_same(plain, run<Dual<4>>(setup, 60.0, 1e-12), 2e-11);
    check_same(plain, run<double>(setup, 60.0, 1e-14), 2e-10);
  }
}

TEST_CASE("trajectory: bisection lands where Henon's step lands") {
  for (const Setup& setup : setups())
    check_same(run<double>(setup, 60.0, 1e-12), run<double>(setup, 60.0, 1e-12, false), 1e-12);
}

TEST_CASE("trajectory: Coulomb's block on a belt in closed form, in every number type") {
  check_coulomb<double>(3e-14);
  check_coulomb<Dual<4>>(3e-14);
  check_coulomb<long double>(2e-17);
}

TEST_CASE("trajectory: transitions and states differentiate by every kind of parameter") {
  Setup setup = reference_rig();
  setup.contact = 0;
  for (const int slot : {alpha1, alpha2, beta3, eta1, belt_speed, slot("paper.T_s_minus"), slot("paper.A1"),
                         slot("paper.t1"), slot("paper.T_min_minus")})
    check_seed(setup, 30.0, [=](auto& p, auto&, const auto& d) { p[slot] = p[slot] + d; }, 1e-8);
  for (const int i : {0, 2, 3})
    check_seed(setup, 30.0, [=](auto&, auto& s, const auto& d) { s.z[i] = s.z[i] + d; }, 1e-8);
}

TEST_CASE("trajectory: derivatives pass through the transitions of the other laws and of effects") {
  Setup coulomb = block_on_belt(1.0, 0.5, 0.2);
  coulomb.contact = 0;
  for (const int slot : {alpha1, stiffness, slot("coulomb.static_minus"), slot("coulomb.kinetic_minus"), belt_speed})
    check_seed(coulomb, 40.0, [=](auto& p, auto&, const auto& d) { p[slot] = p[slot] + d; }, 1e-9);
  Setup effects = with_effects();
  effects.contact = 0;
  for (const int slot : {slot("harmonic_forcing.a"), slot("harmonic_forcing.w"), slot("belt_speed_ripple.a"),
                         slot("spring_gap_k3.d"), slot("stribeck_peak.v_s")})
    check_seed(effects, 20.0, [=](auto& p, auto&, const auto& d) { p[slot] = p[slot] + d; }, 1e-7);
}

TEST_CASE("trajectory: the reference rig makes 191 transitions to t = 1000") {
  const auto r = run<double>(reference_rig(), 1000.0, 1e-10);
  CHECK(r.summary.transitions == 191);
  CHECK(r.summary.outcome == Outcome::finished);
  CHECK(r.end.t == 1000.0);
}

TEST_CASE("trajectory: a run that is stopped says why") {
  System<double> sys;
  prepare(reference_rig(), sys);
  State<double> s{{0.1, 0.1}, 0.0};
  const auto outcome = [&](double fixed_step, long most, const State<double>& from, auto&& stop) {
    Machine<double> m(sys, {1e-10, 1e-10, 1000.0, true, 15, fixed_step, most});
    m.start(from, 2);
    m.run([](const auto&...) {}, [](const auto&...) {}, [](auto&) {}, stop);
    return m.summary.outcome;
  };
  const auto never = [] { return false; };
  CHECK(outcome(0.0, 10, s, never) == Outcome::too_many_transitions);
  CHECK(outcome(0.01, 1000, s, [] { return true; }) == Outcome::interrupted);
  CHECK(outcome(1e-300, 1000, State<double>{{0.1, 0.1}, 1.0}, never) == Outcome::step_too_small);
  CHECK(outcome(0.0, 1000, State<double>{{1e308, 1e308, 1e308, 1e308}, 0.0}, never) == Outcome::not_finite);
  CHECK(outcome(0.0, 1000, s, never) == Outcome::finished);
}

TEST_CASE("trajectory: a run of too many steps keeps what it has") {
  System<double> sys;
  prepare(reference_rig(), sys);
  Machine<double> m(sys, {1e-10, 1e-10, 1000.0, true, 15, 0.0, 1000, 50});
  m.start(State<double>{{0.1, 0.1}, 0.0}, 2);
  int seen = 0;
  m.run([](const auto&...) {}, [](const auto&...) {}, [&](auto&) { ++seen; }, [] { return false; });
  CHECK(m.summary.outcome == Outcome::too_many_steps);
  CHECK(m.summary.steps == 50);
  CHECK(seen == 50);
  CHECK(m.summary.t > 1);
}

TEST_CASE("trajectory: the order grows with the digits asked for, within its bounds") {
  CHECK(order_for(1.0) == 4);
  CHECK(order_for(1e-300) <= max_order);
  for (double tolerance = 1e-2; tolerance > 1e-18; tolerance *= 0.1)
    CHECK(order_for(tolerance * 0.1) >= order_for(tolerance));
}
