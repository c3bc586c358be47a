#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "stickslip/filter.hpp"

using namespace stickslip;

namespace {

std::vector<double> signal(std::size_t count) {
  std::vector<double> x(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto s = static_cast<double>(i);
    x[i] = std::sin(0.37 * s) + 0.2 * std::cos(1.9 * s * s);
  }
  return x;
}

// The recursion in long double: the truth for rounding errors.
double worst_error(const std::vector<double>& x, const std::vector<double>& y, std::size_t channels,
                   const Recursion& c) {
  std::vector<long double> t(x.size(), 0.0L);
  long double worst = 0.0L;
  for (std::size_t i = channels; i < x.size(); ++i) {
    t[i] = static_cast<long double>(c.a) * t[i - channels] + static_cast<long double>(c.k0) * x[i] +
           static_cast<long double>(c.k1) * x[i - channels];
    worst = std::max(worst, std::abs(t[i] - static_cast<long double>(y[i])));
  }
  return static_cast<double>(worst);
}

}  // namespace

TEST_CASE("every length and channel count agrees with long double to rounding") {
  for (const double a : {0.0, 0.3, 0.97, 0.9999, -0.8}) {
    const Recursion c{a, 2.0, -1.25};
    // one rounding a step of size eps*(|k0|+|k1|)*max|x|, accumulated with weights |a|^j
    const double bound = 8.0 * std::numeric_limits<double>::epsilon() * 3.25 * 1.2 / (1.0 - std::abs(a));
    for (std::size_t channels = 1; channels <= 19; ++channels) {
      for (const std::size_t n : {1UL, 2UL, 3UL, 7UL, 8UL, 9UL, 17UL, 64UL, 1023UL, 1026UL, 2500UL}) {
        const auto x = signal(n * channels);
        std::vector<double> y(x.size(), 99.0);
        REQUIRE(first_order(x.data(), y.data(), n, channels, c));
        for (std::size_t k = 0; k < channels; ++k) REQUIRE(y[k] == 0.0);
        REQUIRE(worst_error(x, y, channels, c) <= bound);
      }
    }
  }
}

TEST_CASE("nothing is written outside y and nothing at all for no samples") {
  const auto x = signal(40);
  std::vector<double> y(42, 7.0);
  CHECK(first_order(x.data(), y.data() + 1, 40, 1, {0.5, 1.0, -1.0}));
  CHECK(y.front() == 7.0);
  CHECK(y.back() == 7.0);
  CHECK(first_order(x.data(), y.data(), 0, 1, {0.5, 1.0, -1.0}));
  CHECK(first_order(x.data(), y.data(), 5, 0, {0.5, 1.0, -1.0}));
  CHECK(y.front() == 7.0);
}

TEST_CASE("a channel at rest far from zero has a derivative of exactly zero") {
  for (std::size_t channels : {1UL, 2UL, 3UL, 5UL, 8UL, 11UL}) {
    const std::vector<double> x(3000 * channels, 1.0 / 3.0 * 1e9);
    std::vector<double> y(x.size(), 1.0);
    REQUIRE(first_order(x.data(), y.data(), 3000, channels, {0.9, 1234.5678, -1234.5678}));
    for (const double v : y) REQUIRE(v == 0.0);
  }
}

TEST_CASE("a NaN or an infinity anywhere is told") {
  for (std::size_t channels : {1UL, 2UL, 3UL, 4UL, 6UL, 8UL, 13UL}) {
    const std::size_t count = channels * 150;
    for (std::size_t bad = 0; bad < count; ++bad) {
      auto x = signal(count);
      std::vector<double> y(count);
      x[bad] = bad % 2 == 0 ? std::numeric_limits<double>::quiet_NaN() : -std::numeric_limits<double>::infinity();
      REQUIRE_FALSE(first_order(x.data(), y.data(), 150, channels, {0.5, 1.0, -1.0}));
    }
  }
}

TEST_CASE("constants on or outside the unit circle, or not finite, are not stable") {
  CHECK(is_stable({-0.999, 1.0, 5.0}));
  CHECK_FALSE(is_stable({1.0, 1.0, -1.0}));
  CHECK_FALSE(is_stable({-1.0, 1.0, -1.0}));
  CHECK_FALSE(is_stable({std::nan(""), 1.0, -1.0}));
  CHECK_FALSE(is_stable({0.5, std::numeric_limits<double>::infinity(), -1.0}));
}
