#include "support.hpp"

using namespace support;

namespace {

constexpr double ulp = 0x1p-52;

// Every arithmetic operator of the number types, in every mixture with a plain number.
template <int W>
void check_operators() {
  constexpr std::array<double, 3> x{1.3, -0.7, 2.1};
  check_derivatives<W>([](const auto& a) { return a[0] + a[1]; }, x);
  check_derivatives<W>([](const auto& a) { return a[0] - a[1]; }, x);
  check_derivatives<W>([](const auto& a) { return a[0] * a[1]; }, x);
  check_derivatives<W>([](const auto& a) { return a[0] / a[1]; }, x);
  check_derivatives<W>([](const auto& a) { return a[0] + 0.5; }, x);
  check_derivatives<W>([](const auto& a) { return 0.5 + a[0]; }, x);
  check_derivatives<W>([](const auto& a) { return a[0] - 0.5; }, x);
  check_derivatives<W>([](const auto& a) { return 0.5 - a[0]; }, x);
  check_derivatives<W>([](const auto& a) { return a[0] * 1.5; }, x);
  check_derivatives<W>([](const auto& a) { return 1.5 * a[0]; }, x);
  check_derivatives<W>([](const auto& a) { return a[0] / 1.5; }, x);
  check_derivatives<W>([](const auto& a) { return 1.5 / a[1]; }, x);
  check_derivatives<W>([](const auto& a) { return -a[0]; }, x);
  check_derivatives<W>([](const auto& a) { return a[0] * a[0] / a[0]; }, x);
  check_derivatives<W>([](const auto& a) { return (a[0] - a[1] / a[2]) * (a[1] + a[0] * a[2]) / (a[2] * a[2]); }, x);
}

template <int W>
void check_functions() {
  constexpr std::array<double, 3> x{1.3, -0.7, 2.1};
  check_derivatives<W>([](const auto& a) { return exponential(a[0] * a[1]); }, x);
  check_derivatives<W>([](const auto& a) { return sine(a[0] * a[1]); }, x);
  check_derivatives<W>([](const auto& a) { return cosine(a[0] * a[1]); }, x);
  check_derivatives<W>([](const auto& a) { return square_root(a[0] * a[2]); }, x);
  check_derivatives<W>(
      [](const auto& a) {
        auto s = a[2];
        add_product(s, a[0], a[1]);
        return s;
      },
      x);
  check_derivatives<W>(
      [](const auto& a) {
        auto s = a[0];
        s += a[1];
        s *= a[2];
        s -= a[0];
        s /= a[1];
        return s;
      },
      x);
}

// What W lanes give against the scalar code, lane by lane.
template <int W, class F, class G>
void check_lanes(const F& lanes, const G& scalar, double lo, double hi, double tolerance) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(lo, hi);
  for (int n = 0; n < 2000; ++n) {
    Lanes<W> x(0.0), y(0.0);
    for (int i = 0; i < W; ++i) {
      x.set(i, any(random));
      y.set(i, any(random));
    }
    const Lanes<W> got = lanes(x, y);
    for (int i = 0; i < W; ++i) {
      const double expected = scalar(x[i], y[i]);
      REQUIRE(std::abs(got[i] - expected) <= tolerance * std::abs(expected));
    }
  }
}

template <int W>
void check_all_lanes() {
  const auto both = [](const auto& f, double lo, double hi, double tolerance) {
    check_lanes<W>(f, f, lo, hi, tolerance);
  };
  both([](const auto& x, const auto& y) { return x + y; }, -3, 3, 0);
  both([](const auto& x, const auto& y) { return x - y; }, -3, 3, 0);
  both([](const auto& x, const auto& y) { return x * y; }, -3, 3, 0);
  both([](const auto& x, const auto& y) { return x / y; }, -3, 3, 0);
  both([](const auto& x, const auto&) { return -x; }, -3, 3, 0);
  both([](const auto& x, const auto& y) { return largest(x, y); }, -3, 3, 0);
  both([](const auto& x, const auto&) { return magnitude(x); }, -3, 3, 0);
  both([](const auto& x, const auto&) { return sine(x); }, -3, 3, 0);
  both([](const auto& x, const auto&) { return cosine(x); }, -3, 3, 0);
  both([](const auto& x, const auto&) { return square_root(x); }, 0, 3, 0);
  both([](const auto& x, const auto&) { return exponential(x); }, -800, 800, ulp);
  both([](const auto& x, const auto&) { return rough_exp2(x); }, -1100, 1100, ulp);
  both([](const auto& x, const auto&) { return rough_log2(x * x); }, 1e-9, 1e9, 4 * ulp);
  check_lanes<W>([](const auto& x, const auto& y) { return min(x, y); },
                 [](double x, double y) { return std::min(x, y); }, -3, 3, 0);
  check_lanes<W>(
      [](auto x, const auto& y) {
        add_product(x, x, y);
        x += y;
        x -= Lanes<W>(0.5);
        x *= y;
        return x;
      },
      [](double x, double y) { return ((x + x * y) + y - 0.5) * y; }, 1, 3, 2 * ulp);
}

}  // namespace

TEST_CASE("numbers: dual numbers of every width differentiate every operation") {
  check_operators<4>();
  check_operators<8>();
  check_operators<12>();
  check_functions<4>();
  check_functions<8>();
  check_functions<12>();
}

TEST_CASE("numbers: a constant has no derivatives and a square root of zero no infinite ones") {
  const Dual<8> c(3.0);
  for (int i = 0; i < 8; ++i) CHECK(c.derivative(i) == 0.0);
  Dual<4> x(0.0);
  x.set_derivative(2, 1.0);
  CHECK(std::isfinite(square_root(x).derivative(2)));
}

TEST_CASE("numbers: lanes of every width agree with the scalar code") {
  check_all_lanes<2>();
  check_all_lanes<4>();
  check_all_lanes<8>();
}

TEST_CASE("numbers: the exponential is within a unit in the last place wherever it is normal") {
  for (double x = -707.9; x < 708; x += 0.01037) {
    const long double exact = std::exp(static_cast<long double>(x));
    const auto error = static_cast<double>(std::abs(static_cast<long double>(exponential(x)) - exact) / exact);
    REQUIRE(error <= ulp);
  }
  CHECK(exponential(0.0) == 1.0);
  CHECK(exponential(-1e6) == exponential(-708.0));  // held at the ends: no infinity, no subnormal
  CHECK(exponential(1e6) == exponential(708.0));
  CHECK(std::isfinite(exponential(1e6)));
  CHECK(exponential(-1e6) > 0.0);
}

TEST_CASE("numbers: rough logarithm and power keep the accuracy the step length needs") {
  for (double x = 1e-290; x < 1e290; x *= 1.0137) {
    REQUIRE(std::abs(rough_log2(x) - std::log2(x)) <= 3e-5);
  }
  CHECK(rough_log2(1.0) == 0.0);
  CHECK(rough_log2(0x1p-300) == -300.0);
  for (double x = -999.0; x < 999.0; x += 0.0173) {
    const long double exact = std::exp2(static_cast<long double>(x));
    REQUIRE(std::abs(static_cast<long double>(rough_exp2(x)) / exact - 1) <= 1e-4L);
  }
}
