#include "support.hpp"

using namespace support;

namespace {

constexpr int n = 20;

double factorial(int k) { return std::tgamma(k + 1.0); }

// Coefficients of f(t) = c e^(a t).
template <class T>
void exponential_coefficients(const T& c, const T& a, T* out) {
  out[0] = c;
  for (int k = 1; k <= n; ++k) out[k] = out[k - 1] * a / static_cast<double>(k);
}

}  // namespace

TEST_CASE("series: the product of two exponentials is the exponential of the sum") {
  double a[n + 1], b[n + 1], expected[n + 1];
  exponential_coefficients(1.5, 0.7, a);
  exponential_coefficients(-2.0, -1.9, b);
  exponential_coefficients(-3.0, 0.7 - 1.9, expected);
  for (int k = 0; k <= n; ++k) CHECK(product(a, b, k) == doctest::Approx(expected[k]).epsilon(1e-12).scale(1e-3));
}

TEST_CASE("series: partial products skip what they are told to") {
  const double a[] = {1, 2, 3, 4, 5, 6}, b[] = {7, 11, 13, 17, 19, 23};
  for (int from = 0; from <= 5; ++from) {
    for (int to = from; to <= 5; ++to) {
      double expected = 0;
      for (int j = from; j <= to; ++j) expected += a[j] * b[5 - j];
      CHECK(partial_product(a, b, 5, from, to) == expected);
    }
  }
}

TEST_CASE("series: e^a for a line, and for a parabola by its Hermite recurrence") {
  double slope[n + 1] = {}, e[n + 1];
  slope[1] = 0.8;  // a = 0.3 + 0.8 t
  e[0] = std::exp(0.3);
  for (int k = 1; k <= n; ++k) {
    e[k] = exponential_next(slope, e, k);
    CHECK(e[k] == doctest::Approx(std::exp(0.3) * std::pow(0.8, k) / factorial(k)).epsilon(1e-13));
  }
  slope[1] = 0, slope[2] = -2;  // a = -t^2: even coefficients (-1)^j / j!
  e[0] = 1;
  for (int k = 1; k <= n; ++k) {
    e[k] = exponential_next(slope, e, k);
    const double expected = k % 2 == 0 ? std::pow(-1, k / 2) / factorial(k / 2) : 0.0;
    CHECK(e[k] == doctest::Approx(expected).epsilon(1e-13).scale(1e-30));
  }
}

TEST_CASE("series: two exponentials of one argument go in pairs") {
  double slope[n + 1], one[n + 1], two[n + 1], scaled[n + 1];
  Pair<double> e[n + 1];
  for (int k = 0; k <= n; ++k) slope[k] = k * std::pow(0.4, k);
  for (int k = 0; k <= n; ++k) scaled[k] = slope[k] * -2.5;
  e[0] = exponential(paired(0.2, -0.5));
  one[0] = std::exp(0.2), two[0] = std::exp(-0.5);
  for (int k = 1; k <= n; ++k) {
    one[k] = exponential_next(slope, one, k);
    two[k] = exponential_next(scaled, two, k);
    Pair<double> s = e[0] * slope[k];
    if (k > 1) s = s + exponential_rest(slope, e, k);
    e[k] = s * paired(1.0, -2.5) * inverse<double>(k);
    CHECK(e[k][0] == doctest::Approx(one[k]).epsilon(1e-13));
    CHECK(e[k][1] == doctest::Approx(two[k]).epsilon(1e-13));
  }
}

TEST_CASE("series: a quotient is the geometric series, and undoes a product") {
  double num[n + 1] = {1.0}, den[n + 1] = {2.0, 0.6}, q[n + 1];  // 1/(2 + 0.6 t)
  for (int k = 0; k <= n; ++k) {
    q[k] = k == 0 ? num[0] / den[0] : quotient_next(num[k], den, q, 1 / den[0], k);
    CHECK(q[k] == doctest::Approx(0.5 * std::pow(-0.3, k)).epsilon(1e-13));
  }
  double a[n + 1], b[n + 1], ab[n + 1];
  for (int k = 0; k <= n; ++k) {
    a[k] = std::cos(1.0 + k) / (1 + k);
    b[k] = 1.5 * std::pow(0.5, k) * (1 + k);
    ab[k] = product(a, b, k);
    q[k] = k == 0 ? ab[0] / b[0] : quotient_next(ab[k], b, q, 1 / b[0], k);
    CHECK(q[k] == doctest::Approx(a[k]).epsilon(1e-11).scale(1));
  }
}

TEST_CASE("series: sine and cosine of a series turn together") {
  double slope[n + 1] = {}, s[n + 1], c[n + 1];
  slope[1] = 1.3;  // of 0.4 + 1.3 t: derivatives of the sine are shifts by a quarter turn
  s[0] = std::sin(0.4), c[0] = std::cos(0.4);
  for (int k = 1; k <= n; ++k) {
    s[k] = rotation_next(slope, c, k);
    c[k] = -rotation_next(slope, s, k);
    const double scale = std::pow(1.3, k) / factorial(k);
    CHECK(s[k] == doctest::Approx(scale * std::sin(0.4 + k * M_PI / 2)).epsilon(1e-12).scale(scale));
    CHECK(c[k] == doctest::Approx(scale * std::cos(0.4 + k * M_PI / 2)).epsilon(1e-12).scale(scale));
  }
}

TEST_CASE("series: Horner value and slope against powers written out") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int order = 1; order <= max_order; ++order) {
    double c[series_size];
    for (double& x : c) x = any(random);
    const double h = any(random);
    long double sum = 0, slope = 0;
    for (int k = 0; k <= order; ++k) {
      sum += c[k] * std::pow(static_cast<long double>(h), k);
      if (k > 0) slope += k * c[k] * std::pow(static_cast<long double>(h), k - 1);
    }
    CHECK(std::abs(evaluate(c, order, h) - static_cast<double>(sum)) < 1e-14);
    CHECK(std::abs(evaluate_slope(c, order, h) - static_cast<double>(slope)) < 1e-13);
    double four[4];
    evaluate_four<double>({c, c, c, c}, order, h, four);
    for (const double value : four) CHECK(std::abs(value - static_cast<double>(sum)) < 1e-14);
  }
}

TEST_CASE("series: reciprocals are the nearest numbers") {
  for (int k = 1; k <= series_size; ++k) CHECK(inverse<double>(k) == 1.0 / k);
  for (int k = 1; k <= series_size; ++k) CHECK(inverse<long double>(k) == 1.0L / k);
}

TEST_CASE("series: recurrences carry derivatives") {
  const auto last = [](const auto& x) {
    using T = std::decay_t<decltype(x[0])>;
    T slope[9], e[9], den[9], q[9], s[9], c[9];
    for (int k = 0; k <= 8; ++k) slope[k] = x[0] * static_cast<double>(k) + x[1];
    e[0] = exponential(x[0]);
    s[0] = sine(x[1]);
    c[0] = cosine(x[1]);
    for (int k = 0; k <= 8; ++k) den[k] = x[2] + x[0] * (0.1 * k);
    q[0] = x[1] / den[0];
    for (int k = 1; k <= 8; ++k) {
      e[k] = exponential_next(slope, e, k);
      s[k] = rotation_next(slope, c, k);
      c[k] = -rotation_next(slope, s, k);
      q[k] = quotient_next(x[0], den, q, T(T(1.0) / den[0]), k);
    }
    return product(e, q, 8) + product(s, c, 7) + evaluate(e, 8, x[2] * 0.1) + evaluate_slope(q, 8, x[1] * 0.1);
  };
  check_derivatives<4>(last, std::array<double, 3>{0.4, 0.7, 1.9}, 1e-10);
}
