// (2.1) and the block on a belt as one linear vector field, the modes a trajectory moves through, and the series of
// a piece of it.
//
//   x1' = x2     x2' = -kx x1 - (e1 (x2 + y2) + s y1 + T) / a1      T = sgn(v_w) R(|v_w|), v_w = x2 - v_b
//   y1' = y2     y2' = (-b3 y1 - e12 y2 - x1 - e1 x2) / a2
// with kx = 1 for the rig; the block on a belt has no y, kx = stiffness/mass, a1 = mass, e1 = damping.
#pragma once

#include "stickslip/friction.hpp"
#include "stickslip/series.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
struct Rig {
  T a1, over_a1, kx, e1, s;
  T over_a2, b3, e12;
  T v_b;
  bool two;
};

template <class T>
Rig<T> make_rig(RigKind kind, const Parameters<T>& p) {
  Rig<T> r{};
  r.two = kind == RigKind::two_degree;
  r.a1 = p[alpha1];
  r.over_a1 = T(1.0) / p[alpha1];
  r.e1 = p[eta1];
  r.v_b = p[belt_speed];
  r.kx = r.two ? T(1.0) : p[stiffness] * r.over_a1;
  if (r.two) {
    r.s = p[coupling];
    r.over_a2 = T(1.0) / p[alpha2];
    r.b3 = p[beta3];
    r.e12 = p[eta12];
  }
  return r;
}

// The bracket of (2.1) without friction; times -1 it is the friction T a stuck block asks of the belt, less inertia.
template <class T>
T bracket(const Rig<T>& r, const T& x2, const T& y1, const T& y2) {
  return r.e1 * (x2 + y2) + r.s * y1;
}
template <class T>
T leg_acceleration(const Rig<T>& r, const T& x1, const T& x2, const T& y1, const T& y2) {
  return -(r.b3 * y1 + r.e12 * y2 + x1 + r.e1 * x2) * r.over_a2;
}

// q = a1 kx x1 + e1 (v_b + y2) + s y1: the force a belt of steady speed must supply to a stuck block.
template <class T>
T demand(const Rig<T>& r, const T& x1, const T& x2, const T& y1, const T& y2) {
  return r.a1 * r.kx * x1 + bracket(r, x2, y1, y2);
}

// The discrete part of the state. Only `contact` and `saturated` move without effects.
struct Mode {
  int contact = 0;         // -1 slip with v_w < 0, 0 stick, 1 slip with v_w > 0
  bool saturated = false;  // the branch holds its floor
  int x2_sign = 1;         // block_quadratic_damping
  int gap = 0;             // spring_gap_k3: -1 below -d, 1 above d
  int pivot = 1;           // pivot_dry_friction: sign of y2, 0 stuck
  bool lifted = false;     // normal_force_feedback: no contact force
  int w_sign = 1;          // friction_memory
  int knot = 0;            // tabulated term: interval, 0 below the first knot
  int cycle = 0;           // tabulated term in t: whole periods passed
};

template <class T>
struct State {
  T z[state_count];
  T t;
};

template <class T>
struct Series {
  T x1[series_size], x2[series_size], y1[series_size], y2[series_size];
};

// One more coefficient of y and of x1 from coefficient k.
template <class T>
void extend_positions(const Rig<T>& r, Series<T>& s, int k) {
  const Real<T> over = inverse<T>(k + 1);
  s.x1[k + 1] = s.x2[k] * over;
  if (r.two) {
    s.y1[k + 1] = s.y2[k] * over;
    s.y2[k + 1] = leg_acceleration(r, s.x1[k], s.x2[k], s.y1[k], s.y2[k]) * over;
  } else {
    s.y1[k + 1] = s.y2[k + 1] = T(0.0);
  }
}

// Stick: x2 = v_b.
template <class T>
void expand_stick(const Rig<T>& r, int order, Series<T>& s) {
  for (int k = 0; k < order; ++k) {
    extend_positions(r, s, k);
    s.x2[k + 1] = T(0.0);
  }
}

// Slip in direction `dir` along a line c0 + c1 u (a saturated branch: c1 = 0). Linear with constant coefficients, so
// the series converges everywhere and a few long steps reach machine precision.
template <class T>
void expand_line(const Rig<T>& r, const T& c0, const T& c1, const Real<T>& dir, int order, Series<T>& s) {
  const T damping = c1 * r.over_a1, level = (dir * c0 - c1 * r.v_b) * r.over_a1;
  for (int k = 0; k < order; ++k) {
    extend_positions(r, s, k);
    T a = r.kx * s.x1[k] + bracket(r, s.x2[k], s.y1[k], s.y2[k]) * r.over_a1 + damping * s.x2[k];
    if (k == 0) a = a + level;
    s.x2[k + 1] = -a * inverse<T>(k + 1);
  }
}

// Slip along a curved branch: c0 + c1 u + c2 u^2 and two exponentials or a rational term.
template <Shape shape, class T>
void expand_curve(const Rig<T>& r, const Branch<T>& b, const Real<T>& dir, int order, Series<T>& s) {
  T u[series_size], slope[series_size], e1[series_size], e2[series_size];
  u[0] = (s.x2[0] - r.v_b) * dir;
  T over(0.0);
  if constexpr (shape == Shape::exponentials) {
    e1[0] = b.a1 * exponential(b.k1 * u[0]);
    e2[0] = b.a2 * exponential(b.k2 * u[0]);
  } else {
    slope[0] = T(1.0) + b.decay * u[0];
    over = T(1.0) / slope[0];
    e1[0] = b.rational * over;
  }
  const T scale = dir * r.over_a1;
  for (int k = 0; k < order; ++k) {
    if (k > 0) {
      u[k] = s.x2[k] * dir;
      if constexpr (shape == Shape::exponentials) {
        slope[k] = u[k] * Real<T>(static_cast<double>(k));
        e1[k] = exponential_next(slope, e1, k) * b.k1;
        e2[k] = exponential_next(slope, e2, k) * b.k2;
      } else {
        slope[k] = b.decay * u[k];
        e1[k] = quotient_next(T(0.0), slope, e1, over, k);
      }
    }
    extend_positions(r, s, k);
    T friction = b.c1 * u[k];
    if (k == 0) friction = friction + b.c0;
    if constexpr (shape == Shape::exponentials) {
      friction = friction - e1[k] - e2[k];
    } else {
      friction = friction + e1[k] + b.c2 * product(u, u, k);
    }
    const T a = r.kx * s.x1[k] + bracket(r, s.x2[k], s.y1[k], s.y2[k]) * r.over_a1 + friction * scale;
    s.x2[k + 1] = -a * inverse<T>(k + 1);
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
