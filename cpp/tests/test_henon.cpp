#include "support.hpp"

using namespace support;

namespace {

using Roots = std::vector<double>;

// scale * prod (r - t) with the sign that makes it positive just after t = 0.
std::vector<double> from_roots(const Roots& roots, double scale = 1.0) {
  std::vector<long double> c{static_cast<long double>(scale)};
  for (const double r : roots) {
    std::vector<long double> next(c.size() + 1, 0.0L);
    for (std::size_t k = 0; k < c.size(); ++k) {
      next[k] -= c[k] * r;
      next[k + 1] += c[k];
    }
    c = next;
  }
  const auto lead = std::find_if(c.begin(), c.end(), [](long double x) { return x != 0; });
  const long double sign = *lead > 0 ? 1 : -1;
  std::vector<double> out;
  for (const long double x : c) out.push_back(static_cast<double>(sign * x));
  return out;
}

struct Found {
  bool found;
  double t;
};
Found crossing(std::vector<double> c, double h, bool on_surface = false, bool henon = true) {
  if (c.size() < 3) c.resize(3);  // the order of a series is at least 2
  Found r{false, -1.0};
  r.found = first_crossing(c.data(), static_cast<int>(c.size()) - 1, h, on_surface, henon, r.t);
  return r;
}

// How far a root moves when every coefficient is off by a rounding error.
double rounding_of_root(const std::vector<double>& c, double t) {
  double size = 0, slope = 0;
  for (std::size_t k = 0; k < c.size(); ++k) {
    size += std::abs(c[k]) * std::pow(t, static_cast<double>(k));
    if (k > 0) slope += static_cast<double>(k) * c[k] * std::pow(t, static_cast<double>(k) - 1);
  }
  return 8 * 0x1p-52 * size / std::abs(slope) + 4 * 0x1p-52 * t;
}

}  // namespace

TEST_CASE("henon: Bernstein coefficients and their halves are the same polynomial") {
  const std::vector<double> c{1.0, -2.0, 0.5, 3.0, -1.5, 0.25};
  double b[series_size], right[series_size];
  const auto casteljau = [](const double* p, double x) {
    double w[series_size];
    std::copy(p, p + 6, w);
    for (int i = 1; i <= 5; ++i)
      for (int j = 0; j <= 5 - i; ++j) w[j] = (1 - x) * w[j] + x * w[j + 1];
    return w[0];
  };
  to_bernstein(c.data(), 5, b);
  for (double x = 0; x <= 1; x += 0.1) CHECK(casteljau(b, x) == doctest::Approx(evaluate(c.data(), 5, x)));
  halve(b, 5, right);
  for (double x = 0; x <= 1; x += 0.1) {
    CHECK(casteljau(b, x) == doctest::Approx(evaluate(c.data(), 5, x / 2)));
    CHECK(casteljau(right, x) == doctest::Approx(evaluate(c.data(), 5, 0.5 + x / 2)));
  }
}

TEST_CASE("henon: a single root is landed on to rounding, by both locators") {
  for (const double root : {1e-12, 1e-6, 0.01, 0.3, 0.999999, 1.0 - 1e-14}) {
    for (const bool henon : {true, false}) {
      const auto r = crossing(from_roots({root, -2.0, 3.0}), 1.0, false, henon);
      REQUIRE(r.found);
      CHECK(std::abs(r.t - root) <= 4e-16 * root + 1e-16);
    }
  }
}

TEST_CASE("henon: S and its slope together are those of Horner") {
  const std::vector<double> c{1.0, -2.0, 0.5, 3.0, -1.5, 0.25, 0.1};
  for (int n = 1; n <= 6; ++n) {
    for (const double t : {0.0, 0.3, 1.1}) {
      double s = 0, slope = 0;
      value_and_slope(c.data(), n, t, s, slope);
      CHECK(s == doctest::Approx(evaluate(c.data(), n, t)).epsilon(1e-14).scale(1));
      CHECK(slope == doctest::Approx(evaluate_slope(c.data(), n, t)).epsilon(1e-14).scale(1));
    }
  }
}

TEST_CASE("henon: no root inside the step, none found") {
  CHECK_FALSE(crossing(from_roots({1.1, -2.0}), 1.0).found);
  CHECK_FALSE(crossing({1.0, 0.0, 1.0}, 1.0).found);
  CHECK_FALSE(crossing(from_roots({-0.1, -0.2, -0.3}), 1.0).found);
}

TEST_CASE("henon: of an even number of roots in a step the first is found, however close they are") {
  for (double gap = 0.5; gap > 1e-7; gap *= 0.3) {
    const double first = 0.317;
    const auto c = from_roots({first, first + gap});
    for (const bool henon : {true, false}) {
      const auto r = crossing(c, 1.0, false, henon);
      INFO("gap ", gap);
      REQUIRE(r.found);
      CHECK(std::abs(r.t - first) <= rounding_of_root(c, first) + 1e-15 / gap);
    }
  }
  const auto four = from_roots({0.2, 0.4, 0.6, 0.8});
  CHECK(crossing(four, 1.0).t == doctest::Approx(0.2).epsilon(1e-13));
}

TEST_CASE("henon: a tangency is a graze: no root, or one beside the point of contact") {
  for (const double touch : {0.1, 0.5, 0.77}) {
    const auto clear = crossing({touch * touch + 1e-9, -2 * touch, 1.0}, 1.0);  // passes at 1e-9
    CHECK_FALSE(clear.found);
    const auto deep = crossing({touch * touch - 1e-9, -2 * touch, 1.0}, 1.0);
    REQUIRE(deep.found);
    CHECK(deep.t == doctest::Approx(touch - std::sqrt(1e-9)).epsilon(1e-9));
    const auto graze = crossing({touch * touch, -2 * touch, 1.0}, 1.0);
    CHECK((!graze.found || std::abs(graze.t - touch) < 1e-7));
  }
}

TEST_CASE("henon: a root at the start is divided out, whatever its order") {
  for (const int order : {1, 2, 3}) {
    Roots roots(static_cast<std::size_t>(order), 0.0);
    auto c = from_roots(roots);
    CHECK_FALSE(crossing(c, 1.0, true).found);  // t^order: leaves for good
    roots.push_back(0.6);
    c = from_roots(roots);
    for (const bool henon : {true, false}) {
      const auto r = crossing(c, 1.0, true, henon);
      INFO("order ", order);
      REQUIRE(r.found);
      CHECK(r.t == doctest::Approx(0.6).epsilon(1e-14));
    }
    CHECK(departure_order(c.data(), static_cast<int>(c.size()) - 1, 1.0) == order);
    CHECK_FALSE(crossing(c, 0.599, true).found);
  }
}

TEST_CASE("henon: a departure that turns back at once is told at once") {
  const auto r = crossing({0.0, -1.0, 0.5}, 1.0, true);
  CHECK(r.found);
  CHECK(r.t == 0.0);
  CHECK(crossing({-1e-3, 1.0}, 1.0).found);
}

TEST_CASE("henon: a root at the very end of the step is found once, by this step or the next") {
  for (const double root : {0.25, 0.7}) {
    const auto c = from_roots({root, -1.0});
    CHECK_FALSE(crossing(c, root * (1 - 1e-14)).found);
    const auto after = crossing(c, root * (1 + 1e-14));
    REQUIRE(after.found);
    CHECK(after.t == doctest::Approx(root).epsilon(1e-15));
  }
}

TEST_CASE("henon: random polynomials with known roots: the first root, the same by bisection") {
  std::mt19937 random(20);
  std::uniform_real_distribution<double> any(-1.0, 2.0), scale(-3.0, 3.0);
  int inside = 0;
  for (int n = 0; n < 4000; ++n) {
    Roots roots;
    const std::size_t degree = 1 + random() % 12;
    while (roots.size() < degree) {
      const double r = any(random);
      const bool apart =
          std::all_of(roots.begin(), roots.end(), [&](double other) { return std::abs(r - other) > 0.02; });
      if (apart && std::abs(r) > 0.01 && std::abs(r - 1) > 1e-3) roots.push_back(r);
    }
    const auto c = from_roots(roots, std::exp(scale(random)));
    double first = 2;
    for (const double r : roots)
      if (r > 0) first = std::min(first, r);
    const auto newton = crossing(c, 1.0), bisection = crossing(c, 1.0, false, false);
    REQUIRE(newton.found == (first < 1));
    REQUIRE(bisection.found == newton.found);
    if (!newton.found) continue;
    ++inside;
    const double allowed = rounding_of_root(c, first);
    REQUIRE(std::abs(newton.t - first) <= allowed);
    REQUIRE(std::abs(newton.t - bisection.t) <= allowed);
  }
  CHECK(inside > 1000);
}

TEST_CASE("henon: random series whose sampled minimum is negative are never passed over") {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int n = 0; n < 4000; ++n) {
    std::vector<double> c(4 + random() % 20);
    for (double& x : c) x = any(random);
    c[0] = 0.05 + std::abs(c[0]);
    const auto r = crossing(c, 1.0);
    const int order = static_cast<int>(c.size()) - 1;
    for (double t = 0; t < (r.found ? r.t * (1 - 1e-9) : 1.0); t += 1.0 / 256)
      REQUIRE(evaluate(c.data(), order, t) > -1e-12);
    if (r.found) REQUIRE(std::abs(evaluate(c.data(), order, r.t)) <= 1e-13);
  }
}

TEST_CASE("henon: what surely falls has its only root inside the ends") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  int sure = 0;
  for (int n = 0; n < 4000; ++n) {
    double c[8];
    for (int k = 0; k < 8; ++k) c[k] = any(random) * std::pow(0.4, k);
    if (!surely_falling(c, 7, 1.0)) continue;
    ++sure;
    for (double t = 0; t <= 1.0; t += 0.01) REQUIRE(evaluate_slope(c, 7, t) < 0);
  }
  CHECK(sure > 100);
}

TEST_CASE("henon: the inverse cubic hits a line's root and stays inside the step") {
  CHECK(inverse_hermite(1.0, -2.0, -1.0, -2.0, 1.0) == doctest::Approx(0.5));
  CHECK(inverse_hermite(0.3, -1.0, -0.7, -1.0, 1.0) == doctest::Approx(0.3));
  const double t = inverse_hermite(1.0, -1e-9, -1.0, -50.0, 1.0);
  CHECK(t > 0);
  CHECK(t < 1);
}
