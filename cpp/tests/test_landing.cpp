#include "stickslip/landing.hpp"

#include <random>

#include "support.hpp"

using namespace support;

namespace {

// Series like those of a step: coefficients that fall off as a convergence radius of some steps makes them.
template <int W>
void fill(std::mt19937& random, int order, Lanes<W>* d) {
  std::uniform_real_distribution<double> value(-1, 1), level(0.01, 1);
  for (int i = 0; i < W; ++i) {
    const double ratio = 0.2 + 0.5 * level(random);
    double size = 1;
    for (int k = 0; k <= order; ++k, size *= ratio) d[k].set(i, k == 0 ? level(random) : size * value(random));
  }
}

// Every lane's answer is that of the scalar code; returns how many lanes were left to it.
template <int W>
int check_landings(std::mt19937& random, int order, int& crossings) {
  Lanes<W> d[series_size];
  fill(random, order, d);
  const unsigned all = (1u << W) - 1;
  const Landings<W> answer = land_lanes(d, order, Lanes<W>(1.0), all);
  CHECK((answer.found | answer.clear | answer.undecided) == all);
  CHECK((answer.found & answer.clear) == 0);
  for (int i = 0; i < W; ++i) {
    double c[series_size], t = 0;
    for (int k = 0; k <= order; ++k) c[k] = d[k][i];
    const bool crosses = first_crossing(c, order, 1.0, false, true, t);
    crossings += crosses;
    if ((answer.undecided >> i & 1u) != 0) continue;
    CHECK((answer.found >> i & 1u) == (crosses ? 1u : 0u));
    if (crosses) CHECK(close(answer.t[i], t, 1e-14));
  }
  return __builtin_popcount(answer.undecided);
}

}  // namespace

TEST_CASE("landing: lanes find the first root that the scalar code finds") {
  std::mt19937 random(7);
  for (const int order : {4, 13, 25}) {
    int undecided = 0, crossings = 0, lanes = 0;
    for (int round = 0; round < 500; ++round, lanes += 14) {
      undecided += check_landings<2>(random, order, crossings);
      undecided += check_landings<4>(random, order, crossings);
      undecided += check_landings<8>(random, order, crossings);
    }
    CHECK(crossings > lanes / 10);
    CHECK(undecided < lanes / 10);
  }
}

TEST_CASE("landing: a start on the surface, or two roots, is left to the scalar code") {
  Lanes<2> d[series_size];
  for (int k = 0; k <= 4; ++k) d[k] = Lanes<2>(0.0);
  d[0].set(0, 1e-30), d[1].set(0, -1.0);                   // rounding decides
  d[0].set(1, 0.08), d[1].set(1, -0.6), d[2].set(1, 1.0);  // (t - 0.2)(t - 0.4)
  const Landings<2> answer = land_lanes(d, 4, Lanes<2>(1.0), 3u);
  CHECK(answer.undecided == 3u);
}

TEST_CASE("landing: a lane whose iteration ends at a later root is left to the scalar code") {
  // (0.2 - t)(0.4 - t)(0.9 - t)(t + 0.05): at first it rises, and a parabola that falls below zero at 1 does so past 0.4
  constexpr double rises[] = {0.0036, 0.041, -0.545, 1.45, -1.0};
  Lanes<2> d[series_size];
  for (int k = 0; k <= 4; ++k) d[k] = Lanes<2>(rises[k]);
  const Landings<2> answer = land_lanes(d, 4, Lanes<2>(1.0), 3u);
  CHECK(answer.undecided == 3u);
  double t = 0;
  CHECK(first_crossing(rises, 4, 1.0, false, true, t));
  CHECK(close(t, 0.2, 1e-14));
}

TEST_CASE("landing: a lane that leaves the surface has the root at its start divided out") {
  Batch<2> b;
  Lanes<2> c[series_size];
  for (int k = 0; k <= 4; ++k) c[k] = Lanes<2>(0.0);
  const Watch<Lanes<2>> watch{c, Lanes<2>(0.25), Lanes<2>(9.0), true, true, watch_contact};
  c[0] = Lanes<2>(0.25), c[1] = Lanes<2>(1.0), c[2] = Lanes<2>(-2.0);  // 0.25 + t - 2 t^2 returns to 0.25 at 0.5
  c[0].set(1, 1.25);                                                   // from above: at the root of 1 + t - 2 t^2
  b.on_lower = Lanes<2>::Bits{-1, 0};
  b.on_upper = Lanes<2>::Bits{};
  Lanes<2> d[series_size];
  positive_inside(b, watch, Side::lower, 4, d);
  const Landings<2> answer = land_lanes(d, 4, Lanes<2>(1.5), 3u);
  CHECK(answer.found == 3u);
  CHECK(close(answer.t[0], 0.5, 1e-15));
  CHECK(close(answer.t[1], 1.0, 1e-15));
}
