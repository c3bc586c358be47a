#include "support.hpp"

using namespace support;

namespace {

constexpr int order = 12;

Watch<double> between(const double* c, double lo, double hi) {
  Watch<double> w;
  w.c = c;
  w.lo = lo;
  w.hi = hi;
  w.has_lo = w.has_hi = true;
  return w;
}

}  // namespace

TEST_CASE("switching: the earliest exit of several watches and both sides") {
  const double up[order + 1] = {0.0, 1.0}, down[order + 1] = {0.0, -1.0};
  Watch<double> watches[] = {between(up, -1.0, 0.9), between(down, -0.4, 1.0), between(up, -1.0, 0.5)};
  watches[1].id = watch_demand;
  watches[2].id = watch_kink;
  const Side on[watch_count] = {};
  auto exit = first_exit(watches, 3, order, 1.0, on, true);
  REQUIRE(exit.found);
  CHECK(exit.watch == 1);
  CHECK(exit.side == Side::lower);
  CHECK(exit.t == doctest::Approx(0.4).epsilon(1e-15));
  exit = first_exit(watches, 3, order, 0.39, on, true);
  CHECK_FALSE(exit.found);
  exit = first_exit(watches, 1, order, 1.0, on, false);
  CHECK(exit.side == Side::upper);
  CHECK(exit.t == doctest::Approx(0.9).epsilon(1e-15));
}

TEST_CASE("switching: of two exits at one time the first in the list is taken") {
  const double up[order + 1] = {0.0, 1.0};
  const Watch<double> watches[] = {between(up, -1.0, 0.5), between(up, -1.0, 0.5)};
  const Side on[watch_count] = {};
  CHECK(first_exit(watches, 2, order, 1.0, on, true).watch == 0);
}

TEST_CASE("switching: a surface just left counts only when it is met again") {
  const double c[order + 1] = {0.5, -1.0, 1.0};  // leaves 0.5 downwards, is back at t = 1
  const Watch<double> watch = between(c, -9.0, 0.5);
  Side on[watch_count] = {};
  on[watch_contact] = Side::upper;
  CHECK_FALSE(first_exit(&watch, 1, order, 0.99, on, true).found);
  const auto exit = first_exit(&watch, 1, order, 1.5, on, true);
  REQUIRE(exit.found);
  CHECK(exit.t == doctest::Approx(1.0).epsilon(1e-14));
  CHECK(opposite(Side::upper) == Side::lower);
  CHECK(opposite(Side::lower) == Side::upper);
}

TEST_CASE("switching: the tail bounds what follows the linear part") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int n = 2; n <= max_order; ++n) {
    double c[series_size] = {};
    for (int k = 0; k <= n; ++k) c[k] = any(random);
    const double h = 0.5 + 0.5 * any(random);
    double expected = 0;
    for (int k = 2; k <= n; ++k) expected += std::abs(c[k]) * std::pow(h, k);
    CHECK(tail(c, n, h) == doctest::Approx(expected).epsilon(1e-13));
  }
}

TEST_CASE("switching: what is surely inside is inside") {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  int sure = 0;
  for (int n = 0; n < 20000; ++n) {
    double c[order + 1];
    for (int k = 0; k <= order; ++k) c[k] = any(random) * std::pow(0.5, k);
    const bool leaving = n % 2 == 0;
    if (leaving) c[0] = n % 4 == 0 ? -0.8 : 0.8;
    const Watch<double> watch = between(c, -0.8, 0.8);
    const double h = 0.5 + 0.5 * any(random);
    for (const Side side : {Side::lower, Side::upper}) {
      if (leaving && (side == Side::lower) != (c[0] < 0)) continue;
      if (!surely_inside(watch, side, leaving, h, tail(c, order, h))) continue;
      ++sure;
      for (double t = h / 64; t <= h; t += h / 64) {
        const double s = side == Side::lower ? evaluate(c, order, t) + 0.8 : 0.8 - evaluate(c, order, t);
        REQUIRE(s > 0);
      }
    }
  }
  CHECK(sure > 2000);
}

TEST_CASE("switching: the polynomial of a side is positive inside and exactly zero where it is left") {
  const double c[order + 1] = {0.3, 2.0, -1.0};
  const Watch<double> watch = between(c, -1.0, 0.7);
  double s[series_size];
  switching_polynomial(watch, Side::lower, false, order, s);
  CHECK(s[0] == 1.3);
  CHECK(s[1] == 2.0);
  switching_polynomial(watch, Side::upper, false, order, s);
  CHECK(s[0] == doctest::Approx(0.4));
  CHECK(s[1] == -2.0);
  switching_polynomial(watch, Side::upper, true, order, s);
  CHECK(s[0] == 0.0);
}

TEST_CASE("switching: the time of a crossing, and the state at it, differentiate as the implicit equation says") {
  const auto landed = [](bool time) {
    return [=](const auto& x) {
      using T = std::decay_t<decltype(x[0])>;
      T c[order + 1];
      for (int k = 0; k <= order; ++k) c[k] = x[0] * (k == 0 ? 1.0 : -0.3 / k) + x[1] * (0.1 * k);
      Watch<T> w;
      w.c = c;
      w.lo = x[2];
      w.has_lo = true;
      const Side on[watch_count] = {};
      const auto exit = first_exit(&w, 1, order, Real<T>(1.0), on, true);
      REQUIRE(exit.found);
      const T t = with_derivatives(c, w.lo, order, exit.t);
      T other[order + 1];
      for (int k = 0; k <= order; ++k) other[k] = x[1] * (1.0 + k) - x[0];
      return time ? t : evaluate_at(other, order, t);
    };
  };
  const std::array<double, 3> x{2.0, 0.05, 1.5};
  check_derivatives<4>(landed(true), x, 1e-10);
  check_derivatives<8>(landed(false), x, 1e-10);
}
