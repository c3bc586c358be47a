#include "support.hpp"

using namespace support;

namespace {

const std::vector<double> knots{-1.0, -0.4, 0.1, 0.35, 1.2, 1.25, 2.0};
const std::vector<double> heights{0.3, -0.2, 0.8, 0.1, -0.5, 0.6, 0.2};

System<double> table_of(const std::vector<double>& x, const std::vector<double>& y) {
  Setup setup = reference_rig();
  setup.structure.effects = effect("tabulated");
  setup.structure.table[0].knots = static_cast<int>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    setup.structure.table[0].knot[i] = x[i];
    setup.p[slot_count + i] = y[i];
  }
  System<double> sys;
  prepare(setup, sys);
  return sys;
}

double value_in(const System<double>& sys, int interval, double x) {
  const double* c = sys.table[0][interval];
  if (interval == 0 || interval == sys.structure.table[0].knots) return c[0];
  const double d = x - sys.structure.table[0].knot[interval - 1];
  return c[0] + d * (c[1] + d * (c[2] + d * c[3]));
}

int interval_of(const System<double>& sys, double x) {
  int i = 0;
  while (i < sys.structure.table[0].knots && x >= sys.structure.table[0].knot[i]) ++i;
  return i;
}

// The natural spline by another route: a + b x + sum d_j |x - x_j|^3 with sum d_j = sum d_j x_j = 0, from a dense
// system solved by elimination in long double.
struct Radial {
  std::vector<double> x;
  std::vector<long double> c;  // d_0.., a, b

  Radial(const std::vector<double>& at, const std::vector<double>& y) : x(at), c(at.size() + 2) {
    const std::size_t n = at.size(), m = n + 2;
    std::vector<std::vector<long double>> a(m, std::vector<long double>(m + 1, 0.0L));
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) a[i][j] = std::pow(std::abs(static_cast<long double>(x[i]) - x[j]), 3);
      a[i][n] = a[n][i] = 1;
      a[i][n + 1] = a[n + 1][i] = x[i];
      a[i][m] = y[i];
    }
    for (std::size_t k = 0; k < m; ++k) {
      std::size_t best = k;
      for (std::size_t i = k; i < m; ++i)
        if (std::abs(a[i][k]) > std::abs(a[best][k])) best = i;
      std::swap(a[k], a[best]);
      for (std::size_t i = 0; i < m; ++i) {
        if (i == k) continue;
        const long double f = a[i][k] / a[k][k];
        for (std::size_t j = k; j <= m; ++j) a[i][j] -= f * a[k][j];
      }
    }
    for (std::size_t k = 0; k < m; ++k) c[k] = a[k][m] / a[k][k];
  }
  double operator()(double t) const {
    const std::size_t n = x.size();
    long double s = c[n] + c[n + 1] * t;
    for (std::size_t j = 0; j < n; ++j) s += c[j] * std::pow(std::abs(static_cast<long double>(t) - x[j]), 3);
    return static_cast<double>(s);
  }
};

}  // namespace

TEST_CASE("table: the spline is the natural one") {
  const System<double> sys = table_of(knots, heights);
  const Radial expected(knots, heights);
  for (double x = -1.0; x < 2.0; x += 0.0071)
    CHECK(value_in(sys, interval_of(sys, x), x) == doctest::Approx(expected(x)).epsilon(1e-11).scale(1));
}

TEST_CASE("table: it passes through its values and is constant outside its knots") {
  const System<double> sys = table_of(knots, heights);
  for (std::size_t i = 0; i < knots.size(); ++i) {
    const int right = static_cast<int>(i) + 1;
    CHECK(value_in(sys, right, knots[i]) == doctest::Approx(heights[i]).epsilon(1e-14));
    CHECK(value_in(sys, right - 1, knots[i]) == doctest::Approx(heights[i]).epsilon(1e-13));
  }
  CHECK(value_in(sys, interval_of(sys, -50.0), -50.0) == heights.front());
  CHECK(value_in(sys, interval_of(sys, 50.0), 50.0) == heights.back());
}

TEST_CASE("table: two knots give a line, and the most knots there may be still a natural spline") {
  const System<double> line = table_of({0.5, 2.5}, {1.0, -3.0});
  for (double x = 0.5; x < 2.5; x += 0.1) CHECK(value_in(line, 1, x) == doctest::Approx(1 - 2 * (x - 0.5)));
  std::vector<double> x, y;
  for (int i = 0; i < max_knots; ++i) {
    x.push_back(0.1 * i + 0.02 * std::sin(5.0 * i));
    y.push_back(std::cos(1.7 * i));
  }
  const System<double> full = table_of(x, y);
  const Radial expected(x, y);
  for (double t = x.front(); t < x.back(); t += 0.0113)
    CHECK(value_in(full, interval_of(full, t), t) == doctest::Approx(expected(t)).epsilon(1e-9).scale(1));
}

TEST_CASE("table: its curve differentiates by its values") {
  const auto at = [](const auto& v) {
    using T = std::decay_t<decltype(v[0])>;
    System<T> sys;
    const Setup setup = reference_rig();
    sys.structure = setup.structure;
    sys.structure.table[0].knots = 4;
    for (int i = 0; i < parameter_count; ++i) sys.p[i] = T(setup.p[static_cast<std::size_t>(i)]);
    for (std::size_t i = 0; i < 4; ++i) {
      sys.structure.table[0].knot[i] = knots[i];
      sys.p[slot_count + static_cast<int>(i)] = v[i];
    }
    build(sys);
    build_tables(sys);
    const T* c = sys.table[0][2];
    const double d = 0.23;
    return T(c[0] + d * (c[1] + d * (c[2] + d * c[3])));
  };
  check_derivatives<4>(at, std::array<double, 4>{0.3, -0.2, 0.8, 0.1});
}
