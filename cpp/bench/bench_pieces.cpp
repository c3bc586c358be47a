// What chose the Taylor series for curved pieces: one slip along (4.2) at several tolerances, by series of several
// orders and by an embedded Runge-Kutta pair of order 5(4) (Dormand and Prince 1980) on the same right-hand side.
// The counters say the error at the end, against the series in long double, and the steps taken.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>

#include "stickslip/slots.hpp"
#include "stickslip/table.hpp"
#include "stickslip/trajectory.hpp"

namespace {

using namespace stickslip;
using namespace stickslip_abi;

constexpr double span = 1.5;
constexpr double start[4] = {0.3, 0.06, 0.02, 0.05};

template <class T>
System<T> reference_rig() {
  System<T> sys{};
  sys.structure.law = law("paper");
  auto& p = sys.p;
  p[alpha1] = T(16.0), p[alpha2] = T(8.0), p[beta3] = T(4.0), p[eta1] = T(0.1), p[eta12] = T(0.2);
  p[coupling] = T(1.0), p[belt_speed] = T(0.1);
  p[slot("paper.T_s_minus")] = T(5.94), p[slot("paper.A1")] = T(3.2345), p[slot("paper.A2")] = T(2.8736),
  p[slot("paper.t1")] = T(0.0342), p[slot("paper.t2")] = T(0.3053);
  p[slot("paper.v_w_min")] = T(-0.28), p[slot("paper.T_min_minus")] = T(1.42), p[slot("paper.T_s_plus")] = T(3.63),
  p[slot("paper.T_min_plus")] = T(0.86);
  p[slot("paper.v_w_max")] = T(0.27);
  build(sys);
  return sys;
}

template <class T>
int taylor(const System<T>& sys, int order, double tolerance, T* z) {
  static Piece<T> piece;
  Mode mode;
  mode.contact = -1;
  State<T> s{};
  std::copy(start, start + 4, s.z);
  int steps = 0;
  for (double t = 0; t < span; ++steps) {
    T unused(0.0);
    expand(sys, mode, s, order, piece, unused);
    const double wanted = static_cast<double>(step_length(sys, mode, s, piece, order, tolerance, tolerance));
    const double h = std::min(wanted, span - t);
    T next[state_count];
    piece_state(sys, mode, piece, s, order, T(h), next);
    std::copy(next, next + 4, s.z);
    t += h;
  }
  std::copy(s.z, s.z + 4, z);
  return steps;
}

void field(const System<double>& sys, const double* z, double* f) {
  const Rig<double>& r = sys.rig;
  const double u = r.v_b - z[1];
  f[0] = z[1];
  f[1] = -r.kx * z[0] - (bracket(r, z[1], z[2], z[3]) - curve(sys.minus, u)) * r.over_a1;
  f[2] = z[3];
  f[3] = leg_acceleration(r, z[0], z[1], z[2], z[3]);
}

constexpr double a[6][6] = {{1.0 / 5},
                            {3.0 / 40, 9.0 / 40},
                            {44.0 / 45, -56.0 / 15, 32.0 / 9},
                            {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
                            {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
                            {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
constexpr double e[7] = {71.0 / 57600, 0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40};

int runge_kutta(const System<double>& sys, double tolerance, double* z) {
  double k[7][4];
  std::copy(start, start + 4, z);
  field(sys, z, k[0]);
  int steps = 0;
  double h = 0.01;
  for (double t = 0; t < span; ++steps) {
    h = std::min(h, span - t);
    double y[4];
    for (int s = 0; s < 6; ++s) {
      for (int i = 0; i < 4; ++i) {
        double sum = 0;
        for (int j = 0; j <= s; ++j) sum += a[s][j] * k[j][i];
        y[i] = z[i] + h * sum;
      }
      field(sys, y, k[s + 1]);
    }
    double error = 0;
    for (int i = 0; i < 4; ++i) {
      double sum = 0;
      for (int j = 0; j < 7; ++j) sum += e[j] * k[j][i];
      error = std::max(error, std::abs(h * sum) / (tolerance * (1 + std::abs(y[i]))));
    }
    const double factor = std::clamp(0.9 * std::pow(error + 1e-30, -0.2), 0.2, 5.0);
    if (error <= 1) {
      t += h;
      std::copy(y, y + 4, z);
      std::copy(k[6], k[6] + 4, k[0]);
    }
    h *= factor;
  }
  return steps;
}

double error_of(const double* z) {
  long double exact[4];
  taylor(reference_rig<long double>(), 28, 1e-18, exact);
  double worst = 0;
  for (int i = 0; i < 4; ++i)
    worst = std::max(worst, static_cast<double>(std::abs(static_cast<long double>(z[i]) - exact[i])));
  return worst;
}

template <class Run>
void measure(benchmark::State& state, const Run& run) {
  double z[4];
  int steps = 0;
  for (auto _ : state) {
    steps = run(z);
    benchmark::DoNotOptimize(z);
  }
  state.counters["error"] = error_of(z);
  state.counters["steps"] = steps;
}

void series(benchmark::State& state) {
  const auto sys = reference_rig<double>();
  const double tolerance = std::pow(10.0, -static_cast<double>(state.range(1)));
  measure(state, [&](double* z) { return taylor(sys, static_cast<int>(state.range(0)), tolerance, z); });
}
void pair(benchmark::State& state) {
  const auto sys = reference_rig<double>();
  const double tolerance = std::pow(10.0, -static_cast<double>(state.range(0)));
  measure(state, [&](double* z) { return runge_kutta(sys, tolerance, z); });
}

BENCHMARK(series)->ArgNames({"order", "digits"})->ArgsProduct({{8, 12, 15, 20, 25}, {6, 8, 10, 12}});
BENCHMARK(pair)->ArgNames({"digits"})->Arg(6)->Arg(8)->Arg(10)->Arg(12);

}  // namespace

BENCHMARK_MAIN();
