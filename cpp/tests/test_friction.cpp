#include "support.hpp"

using namespace support;

namespace {

Parameters<double> reference_parameters() {
  Parameters<double> p;
  const Setup s = reference_rig();
  std::copy(s.p.begin(), s.p.end(), p.p);
  return p;
}

// (4.2), with the exponent 0.28 - u and the floor 1.42; (4.1), with the floor 0.86.
double paper_minus_formula(double u) {
  return std::max(1.42, 5.94 - 3.2345 * std::exp(-(0.28 - u) / 0.0342) - 2.8736 * std::exp(-(0.28 - u) / 0.3053));
}
double paper_plus_formula(double u) { return std::max(0.86, 3.63 - u * (3.63 - 0.86) / 0.27); }

// The law's numbers from an array of varied ones.
template <class X>
auto paper_parameters(const X& x) {
  using T = std::decay_t<decltype(x[0])>;
  Parameters<T> p;
  const Setup s = reference_rig();
  for (int i = 0; i < parameter_count; ++i) p[i] = T(s.p[static_cast<std::size_t>(i)]);
  return p;
}

}  // namespace

TEST_CASE("friction: both measured branches are (4.1)-(4.3) with Table 1") {
  const Parameters<double> p = reference_parameters();
  const Branch<double> minus = branch(law("paper"), p, -1), plus = branch(law("paper"), p, 1);
  for (double u = 0; u < 0.6; u += 0.00173) {
    CHECK(magnitude(minus, u) == doctest::Approx(paper_minus_formula(u)).epsilon(1e-13));
    CHECK(magnitude(plus, u) == doctest::Approx(paper_plus_formula(u)).epsilon(1e-13));
  }
  CHECK(minus.static_limit == 5.94);
  CHECK(magnitude(minus, 0.0) == doctest::Approx(4.7906).epsilon(1e-5));  // a drop at the onset of slip
  CHECK(plus.static_limit == 3.63);
  CHECK(magnitude(plus, 0.0) == 3.63);
  CHECK(minus.kink == doctest::Approx(0.2604250004369009).epsilon(1e-14));
  CHECK(plus.kink == 0.27);
}

TEST_CASE("friction: Coulomb and hyperbolic laws, each direction its own numbers") {
  const Parameters<double> p = reference_parameters();
  for (double u = 0; u < 4; u += 0.13) {
    CHECK(magnitude(branch(law("coulomb"), p, -1), u) == 3.0);
    CHECK(magnitude(branch(law("coulomb"), p, 1), u) == 2.0);
    CHECK(magnitude(branch(law("hyperbolic"), p, -1), u) ==
          doctest::Approx(5 / (1 + 3 * u) + 0.5 + 0.2 * u * u).epsilon(1e-14));
    CHECK(magnitude(branch(law("hyperbolic"), p, 1), u) ==
          doctest::Approx(4 / (1 + 2 * u) + 0.3 + 0.1 * u * u).epsilon(1e-14));
  }
  CHECK(branch(law("coulomb"), p, -1).static_limit == 5.0);
  CHECK(branch(law("coulomb"), p, 1).static_limit == 4.0);
  CHECK(branch(law("hyperbolic"), p, -1).static_limit == 5.5);
  CHECK(branch(law("hyperbolic"), p, 1).static_limit == 4.3);
}

TEST_CASE("friction: slopes of the curves are their derivatives") {
  const Parameters<double> p = reference_parameters();
  for (int one = 0; one < Laws::size; ++one) {
    for (const int direction : {-1, 1}) {
      const Branch<double> b = branch(one, p, direction);
      for (const double u : {0.0, 0.05, 0.1, 0.2, 0.25}) {
        Dual<4> x(u);
        x.set_derivative(0, 1.0);
        const Branch<Dual<4>> seeded = branch(one, paper_parameters(std::array<Dual<4>, 1>{}), direction);
        CHECK(curve_slope(b, u) == doctest::Approx(curve(seeded, x).derivative(0)).epsilon(1e-12));
      }
    }
  }
}

TEST_CASE("friction: magnitudes differentiate by the law's parameters and by the speed") {
  const auto at = [](int kind, int direction, std::array<int, 3> slots) {
    return [=](const auto& x) {
      auto p = paper_parameters(x);
      for (std::size_t i = 0; i < 3; ++i) p[slots[i]] = x[i];
      return magnitude(branch(kind, p, direction), x[3]);
    };
  };
  check_derivatives<4>(at(law("paper"), -1, {slot("paper.T_s_minus"), slot("paper.A1"), slot("paper.A2")}),
                       std::array<double, 4>{5.94, 3.2345, 2.8736, 0.2});
  check_derivatives<4>(at(law("paper"), -1, {slot("paper.t1"), slot("paper.t2"), slot("paper.v_w_min")}),
                       std::array<double, 4>{0.0342, 0.3053, -0.28, 0.2}, 1e-9);
  check_derivatives<4>(at(law("paper"), -1, {slot("paper.T_min_minus"), slot("paper.A1"), slot("paper.A2")}),
                       std::array<double, 4>{1.42, 3.2345, 2.8736, 0.4});
  check_derivatives<4>(at(law("paper"), 1, {slot("paper.T_s_plus"), slot("paper.T_min_plus"), slot("paper.v_w_max")}),
                       std::array<double, 4>{3.63, 0.86, 0.27, 0.1});
  check_derivatives<4>(
      at(law("hyperbolic"), 1,
         {slot("hyperbolic.scale_plus"), slot("hyperbolic.decay_plus"), slot("hyperbolic.quadratic_plus")}),
      std::array<double, 4>{4, 2, 0.1, 0.3});
}

TEST_CASE("friction: the kink moves as the implicit equation R(kink) = floor says") {
  constexpr std::array<int, 4> slots{slot("paper.T_s_minus"), slot("paper.A1"), slot("paper.t1"),
                                     slot("paper.T_min_minus")};
  const auto kink = [&](const auto& x) {
    auto p = paper_parameters(x);
    for (std::size_t i = 0; i < 4; ++i) p[slots[i]] = x[i];
    return branch(law("paper"), p, -1).kink;
  };
  const std::array<double, 4> x{5.94, 3.2345, 0.0342, 1.42};
  check_derivatives<4>(kink, x, 1e-9);
  // by hand: d kink / d floor = 1 / R'(kink), d kink / d T_s = -1 / R'(kink)
  const Branch<double> b = branch(law("paper"), reference_parameters(), -1);
  std::array<Dual<4>, 4> seeded;
  for (std::size_t i = 0; i < 4; ++i) seeded[i] = Dual<4>(x[i]);
  seeded[0].set_derivative(0, 1.0);
  seeded[3].set_derivative(3, 1.0);
  const double slope = curve_slope(b, b.kink);
  CHECK(kink(seeded).derivative(3) == doctest::Approx(1 / slope).epsilon(1e-12));
  CHECK(kink(seeded).derivative(0) == doctest::Approx(-1 / slope).epsilon(1e-12));
  CHECK(curve(b, b.kink) == doctest::Approx(b.saturated).epsilon(1e-14));
}

TEST_CASE("friction: a curve that starts below its floor is all floor; one that never falls has no kink in reach") {
  Parameters<double> p = reference_parameters();
  p[slot("paper.T_min_minus")] = 5.0;  // the curve starts at 4.79
  const Branch<double> flat = branch(law("paper"), p, -1);
  CHECK_FALSE(flat.has_kink);
  CHECK(flat.curve == straight);
  CHECK(flat.static_limit == 5.94);
  for (const double u : {0.0, 0.1, 0.3}) CHECK(magnitude(flat, u) == 5.0);
  p = reference_parameters();
  p[slot("paper.A1")] = p[slot("paper.A2")] = 0;
  const Branch<double> level = branch(law("paper"), p, -1);
  CHECK(std::isinf(level.kink));
  CHECK(magnitude(level, 100.0) == 5.94);
}
