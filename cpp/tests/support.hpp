// What the tests of the core share: derivatives against perturbation, and runs of a model in any number type.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "stickslip/slots.hpp"
#include "stickslip/table.hpp"
#include "stickslip/trajectory.hpp"

namespace support {

using namespace stickslip;
using namespace stickslip_abi;

// Relative to the larger of 1 and the expected size.
inline bool close(double got, double expected, double tolerance) {
  return std::abs(got - expected) <= tolerance * std::max(1.0, std::abs(expected));
}

// Central difference of fourth order in long double: its error is far below that of double arithmetic.
template <class F>
double slope_at_zero(const F& f, long double h) {
  return static_cast<double>((8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h));
}

// f takes an array of N numbers and returns one. Its Dual derivatives against perturbation; arguments are seeded from
// the last derivative backwards, so that every register of a dual number is used.
template <int W, class F, std::size_t N>
void check_derivatives(const F& f, const std::array<double, N>& x, double tolerance = 1e-11) {
  static_assert(N <= W);
  std::array<Dual<W>, N> seeded;
  std::array<long double, N> plain;
  for (std::size_t i = 0; i < N; ++i) {
    seeded[i] = Dual<W>(x[i]);
    seeded[i].set_derivative(W - 1 - static_cast<int>(i), 1.0);
    plain[i] = static_cast<long double>(x[i]);
  }
  const Dual<W> got = f(seeded);
  CHECK(close(got.v, static_cast<double>(f(plain)), tolerance));
  for (std::size_t i = 0; i < static_cast<std::size_t>(W) - N; ++i) CHECK(got.derivative(static_cast<int>(i)) == 0.0);
  for (std::size_t i = 0; i < N; ++i) {
    const auto moved = [&](long double h) {
      auto y = plain;
      y[i] += h;
      return static_cast<long double>(f(y));
    };
    const double expected = slope_at_zero(moved, 1e-4L * std::max(0.1L, std::abs(plain[i])));
    const double derivative = got.derivative(W - 1 - static_cast<int>(i));
    INFO("argument ", i, ": derivative ", derivative, ", by perturbation ", expected);
    CHECK(close(derivative, expected, tolerance));
  }
}

struct Setup {
  Structure structure;
  std::array<double, parameter_count> p{};
  std::array<double, state_count> z{};
  int contact = 2;
};

// The illustrative rig of the documentation: 191 transitions to t = 1000.
inline Setup reference_rig() {
  Setup s;
  s.structure.law = law("paper");
  auto& p = s.p;
  p[alpha1] = 16, p[alpha2] = 8, p[beta3] = 4, p[eta1] = 0.1, p[eta12] = 0.2, p[coupling] = 1, p[belt_speed] = 0.1;
  p[slot("paper.T_s_minus")] = 5.94, p[slot("paper.A1")] = 3.2345, p[slot("paper.A2")] = 2.8736,
  p[slot("paper.t1")] = 0.0342, p[slot("paper.t2")] = 0.3053, p[slot("paper.v_w_min")] = -0.28;
  p[slot("paper.T_min_minus")] = 1.42, p[slot("paper.T_s_plus")] = 3.63, p[slot("paper.T_min_plus")] = 0.86,
  p[slot("paper.v_w_max")] = 0.27;
  p[slot("coulomb.static_minus")] = 5, p[slot("coulomb.kinetic_minus")] = 3, p[slot("coulomb.static_plus")] = 4,
  p[slot("coulomb.kinetic_plus")] = 2;
  p[slot("hyperbolic.scale_minus")] = 5, p[slot("hyperbolic.decay_minus")] = 3,
  p[slot("hyperbolic.constant_minus")] = 0.5, p[slot("hyperbolic.quadratic_minus")] = 0.2;
  p[slot("hyperbolic.scale_plus")] = 4, p[slot("hyperbolic.decay_plus")] = 2, p[slot("hyperbolic.constant_plus")] = 0.3,
  p[slot("hyperbolic.quadratic_plus")] = 0.1;
  s.z = {0.1, 0.1};
  return s;
}

inline Setup block_on_belt(double fixed, double moving, double v_b) {
  Setup s;
  s.structure.rig = RigKind::block_on_belt;
  s.structure.law = law("coulomb");
  s.p[alpha1] = s.p[stiffness] = 1;
  s.p[belt_speed] = v_b;
  s.p[slot("coulomb.static_minus")] = s.p[slot("coulomb.static_plus")] = fixed;
  s.p[slot("coulomb.kinetic_minus")] = s.p[slot("coulomb.kinetic_plus")] = moving;
  s.z = {0.0, v_b};
  return s;
}

template <class T>
void prepare(const Setup& setup, System<T>& sys) {
  sys.structure = setup.structure;
  for (int i = 0; i < parameter_count; ++i) sys.p[i] = T(setup.p[static_cast<std::size_t>(i)]);
  build(sys);
  build_tables(sys);
}

template <class T>
struct Change {
  T t;
  int before, after;
  bool kink;
  T z[state_count];
};

template <class T>
struct Run {
  std::vector<Change<T>> changes;
  State<T> end;
  Summary summary;
};

// `seed(sys.p, s)` moves or seeds parameters and start before the model is built.
template <class T, class Seed>
Run<T> run(const Setup& setup, double t_end, double tolerance, const Seed& seed, bool henon = true) {
  System<T> sys;
  State<T> s;
  sys.structure = setup.structure;
  for (int i = 0; i < parameter_count; ++i) sys.p[i] = T(setup.p[static_cast<std::size_t>(i)]);
  for (int i = 0; i < state_count; ++i) s.z[i] = T(setup.z[static_cast<std::size_t>(i)]);
  s.t = T(0.0);
  seed(sys.p, s);
  build(sys);
  build_tables(sys);
  Machine<T> machine(sys, {tolerance, tolerance, t_end, henon, order_for(tolerance_share * tolerance), 0.0, 100000});
  machine.start(s, setup.contact);
  Run<T> out;
  const auto changed = [&](Machine<T>& m, const Mode& before, bool kink) {
    Change<T> c{m.s.t, before.contact, m.mode.contact, kink, {}};
    std::copy(m.s.z, m.s.z + state_count, c.z);
    out.changes.push_back(c);
  };
  machine.run([](const auto&...) {}, changed, [](auto&) {}, [] { return false; });
  out.end = machine.s;
  out.summary = machine.summary;
  return out;
}

template <class T>
Run<T> run(const Setup& setup, double t_end, double tolerance, bool henon = true) {
  return run<T>(setup, t_end, tolerance, [](auto&, auto&) {}, henon);
}

}  // namespace support
