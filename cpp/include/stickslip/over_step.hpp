// Extremes and integrals over a step, from its series.
#pragma once

#include "stickslip/isa.hpp"

namespace stickslip::inline STICKSLIP_ISA {

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

// Extremes over [from, to]: the ends, and where the slope changes sign between nodes. The nodes are so close that between
// two of them there is one extremum at most: a step on which the series converges spans little more than a turn.
inline void widen(double& low, double& high, const Strided& c, int order, double from, double to) {
  constexpr int parts = 8;
  const auto take = [&](double x) {
    if (x < low) low = x;
    if (x > high) high = x;
  };
  take(at(c, order, from));
  take(at(c, order, to));
  double left = from, slope = slope_at(c, order, from);
  for (int part = 1; part <= parts; ++part) {
    const double right = from + (to - from) * part / parts, next = slope_at(c, order, right);
    if (slope * next < 0) take(at(c, order, turning_point(c, order, left, slope, right, next)));
    left = right;
    slope = next;
  }
}

// Integral over [from, to] of what `power` gives at t: Gauss points.
template <class Power>
double integral(double from, double to, const Power& power) {
  constexpr double x[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  constexpr double w[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
  double sum = 0;
  const double half = 0.5 * (to - from);
  for (int g = 0; g < 8; ++g) sum += w[g % 4] * power(from + half * (1 + (g < 4 ? -x[g] : x[g - 4])));
  return half * sum;
}

}  // namespace stickslip::inline STICKSLIP_ISA
