// What a sweep observes of a trajectory while it runs; nothing of it is stored.
#pragma once

#include "stickslip/piece.hpp"
#include "stickslip/sweep_request.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct Tally {
  SweepRow row;
  double points[max_sweep_points][5];
};

inline void clear(Tally& tally) {
  tally.row = SweepRow{};
  for (int i = 0; i < 4; ++i) {
    tally.row.state_min[i] = std::numeric_limits<double>::infinity();
    tally.row.state_max[i] = -std::numeric_limits<double>::infinity();
  }
}

// One coefficient series of one lane.
struct Strided {
  const double* c;
  int stride;
  double operator[](int k) const { return c[k * stride]; }
};

inline double at(const Strided& c, int order, double h) {
  double s = c[order];
  for (int k = order - 1; k >= 0; --k) s = s * h + c[k];
  return s;
}
inline double slope_at(const Strided& c, int order, double h) {
  double s = c[order] * order;
  for (int k = order - 1; k >= 1; --k) s = s * h + c[k] * k;
  return s;
}

// Where the slope, of different signs sa at a and sb at b, is zero.
inline double turning_point(const Strided& c, int order, double a, double sa, double b, double sb) {
  const double width = 1e-9 * (b - a);
  for (int k = 0; k < 100 && b - a > width; ++k) {  // an extremum needs half the digits of its place
    double t = k % 3 == 2 ? 0.5 * (a + b) : a - sa * (b - a) / (sb - sa);
    if (!(t > a && t < b)) t = 0.5 * (a + b);
    const double st = slope_at(c, order, t);
    if (st * sa > 0) {
      a = t;
      sa = st;
    } else {
      b = t;
      sb = st;
    }
  }
  return 0.5 * (a + b);
}

// Extremes over [0, h]: the ends, and where the slope changes sign between nodes. The nodes are so close that between two
// of them there is one extremum at most: a step on which the series converges spans little more than a turn.
inline void widen(Tally& tally, int i, const Strided& c, int order, double h) {
  constexpr int parts = 8;
  const auto take = [&](double x) {
    if (x < tally.row.state_min[i]) tally.row.state_min[i] = x;
    if (x > tally.row.state_max[i]) tally.row.state_max[i] = x;
  };
  take(c[0]);
  take(at(c, order, h));
  double left = 0, slope = c[1];
  for (int part = 1; part <= parts; ++part) {
    const double right = h * part / parts, next = slope_at(c, order, right);
    if (slope * next < 0) take(at(c, order, turning_point(c, order, left, slope, right, next)));
    left = right;
    slope = next;
  }
}

// Integral over [0, h] of what `power` gives at t: Gauss points.
template <class Power>
double integral(double h, const Power& power) {
  constexpr double x[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  constexpr double w[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
  double sum = 0;
  for (int g = 0; g < 8; ++g) sum += w[g % 4] * power(0.5 * h * (1 + (g < 4 ? -x[g] : x[g - 4])));
  return 0.5 * h * sum;
}

// Work of friction on the sliding contact, integral of T v_w: T is what the motion says, where nothing else acts.
inline double work(const Rig<double>& r, const Strided* z, int order, double h, double belt) {
  return integral(h, [&](double t) {
    double v[4];
    for (int i = 0; i < 4; ++i) v[i] = at(z[i], order, t);
    const double friction = -(r.a1 * (slope_at(z[1], order, t) + r.kx * v[0]) + bracket(r, v[1], v[2], v[3]));
    return friction * (v[1] - belt);
  });
}

// The same of a piece with effects, which has the series of both.
inline double work(const Strided& friction, const Strided& v_w, int order, double h) {
  return integral(h, [&](double t) { return at(friction, order, t) * at(v_w, order, t); });
}

// A step of length h of a piece, seen from `after` on.
inline void observe_step(Tally& tally, std::uint32_t what, const Rig<double>& r, const Strided* z, int contact,
                         int order, double h) {
  if ((what & ob_range) != 0)
    for (int i = 0; i < (r.two ? 4 : 2); ++i) widen(tally, i, z[i], order, h);
  if ((what & ob_dissipated) != 0 && contact != 0) tally.row.dissipated += work(r, z, order, h, r.v_b);
}

// A change of the contact mode, seen from `after` on.
inline void observe_transition(Tally& tally, int points, int before, int now, double t, const double* state) {
  SweepRow& row = tally.row;
  row.transitions += 1;
  if (now == 0) return;
  row.slips += before == 0 ? 1 : 0;
  if (row.releases > 0) {
    const double interval = t - row.last_release;
    row.interval_squares += interval * interval;
  } else {
    row.first_release = t;
  }
  row.last_release = t;
  if (points > 0) {
    double* p = tally.points[static_cast<long>(row.releases) % points];
    p[0] = t;
    for (int i = 0; i < 4; ++i) p[i + 1] = state[i];
  }
  row.releases += 1;
}

}  // namespace stickslip::inline STICKSLIP_ISA
