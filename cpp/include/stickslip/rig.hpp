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
  int pivot = 1;           // pivot_dry_friction: sign of y2, 0 stuck (with a creep speed: within its reach)
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

// Stick: x2 = v_b, so that x1 is a line and the leg swings alone under it. `q` is the series of the force the belt must
// supply. Products with 1/(k + 1) are formed ahead of what the chain of coefficients waits for, here as below.
template <class T>
void expand_stick(const Rig<T>& r, int order, Series<T>& s, T* q) {
  q[0] = demand(r, s.x1[0], s.x2[0], s.y1[0], s.y2[0]);
  extend_positions(r, s, 0);
  s.x2[1] = T(0.0);
  q[1] = demand(r, s.x1[1], s.x2[1], s.y1[1], s.y2[1]);
  extend_positions(r, s, 1);
  s.x1[2] = s.x2[2] = T(0.0);
  const T b3 = r.b3 * r.over_a2, e12 = r.e12 * r.over_a2, e1 = r.e1, coupled = r.s;
  T y1 = s.y1[2], y2 = s.y2[2];
  for (int k = 2; k <= order; ++k) {
    const Real<T> over = inverse<T>(k + 1);
    q[k] = e1 * y2 + coupled * y1;
    const T next = -((b3 * y1) * over) - (e12 * over) * y2;
    y1 = y2 * over;
    y2 = next;
    s.x1[k + 1] = s.x2[k + 1] = T(0.0);
    s.y1[k + 1] = y1;
    s.y2[k + 1] = y2;
  }
}

// Slip in direction `dir` along a line c0 + c1 u (a saturated branch: c1 = 0). Linear with constant coefficients, so
// the series converges everywhere and a few long steps reach machine precision.
template <class T>
void expand_line(const Rig<T>& r, const T& c0, const T& c1, const Real<T>& dir, int order, Series<T>& s) {
  const T damping = (c1 + r.e1) * r.over_a1, stiffness = r.kx, y_damping = r.e1 * r.over_a1,
          y_stiffness = r.s * r.over_a1;
  const T b3 = r.b3 * r.over_a2, e12 = r.e12 * r.over_a2, leg1 = r.over_a2, leg2 = r.e1 * r.over_a2;
  T x1 = s.x1[0], x2 = s.x2[0], y1 = s.y1[0], y2 = s.y2[0], level = (dir * c0 - c1 * r.v_b) * r.over_a1;
  for (int k = 0; k < order; ++k) {
    const Real<T> over = inverse<T>(k + 1);
    const T block = (level + stiffness * x1 + y_stiffness * y1) * over + (y_damping * over) * y2;
    const T leg = (leg1 * x1 + b3 * y1) * over + (e12 * over) * y2;
    const T next = -block - (damping * over) * x2;
    y1 = y2 * over;
    y2 = -leg - (leg2 * over) * x2;
    x1 = x2 * over;
    x2 = next;
    s.x1[k + 1] = x1;
    s.x2[k + 1] = x2;
    s.y1[k + 1] = y1;
    s.y2[k + 1] = y2;
    level = T(0.0);
  }
}

// Slip along the two exponentials of (4.2). The recurrence is a chain of dependent operations, so all that does not
// need the newest coefficient is formed beside it: e holds (a_i/a1) e^(k_i u), `other` the part of u' without e, and
// each turn of the chain is one sum and one multiply-add.
template <class T>
void expand_exponentials(const Rig<T>& r, const Branch<T>& b, const Real<T>& dir, int order, Series<T>& s) {
  T slope[series_size];  // slope[k] = k u_k
  Pair<T> e[series_size];
  const T damping = r.e1 * r.over_a1, stiffness = r.kx * dir, y_damping = damping * dir,
          y_stiffness = r.s * r.over_a1 * dir;
  const T b3 = r.b3 * r.over_a2, e12 = r.e12 * r.over_a2, leg1 = r.over_a2, leg2 = r.e1 * r.over_a2;
  const Pair<T> rate = paired(b.k1, b.k2);
  T x1 = s.x1[0], x2 = s.x2[0], y1 = s.y1[0], y2 = s.y2[0], u = (x2 - r.v_b) * dir;
  e[0] = paired(T(b.a1 * r.over_a1), T(b.a2 * r.over_a1)) * exponential(rate * u);
  const Pair<T> first = e[0] * rate;
  Pair<T> newest = e[0];
  T other = -(b.c0 * r.over_a1) - damping * (x2 * dir - u);  // of u' : all but e and the terms below
  for (int k = 0; k < order; ++k) {
    const Real<T> over = inverse<T>(k + 1);
    Pair<T> rest(0.0);
    if (k > 0) rest = exponential_rest(slope, e, k + 1) * (rate * over);
    other = other - (stiffness * x1 + y_damping * y2 + y_stiffness * y1);
    const T leg = (b3 * y1 + e12 * y2 + leg1 * x1 + leg2 * x2) * over;
    x1 = x2 * over;
    y1 = y2 * over;
    y2 = -leg;
    const T next = (other - damping * u) + sum(newest);
    slope[k + 1] = next;
    newest = rest + first * (next * over);
    e[k + 1] = newest;
    u = next * over;
    x2 = u * dir;
    s.x1[k + 1] = x1;
    s.x2[k + 1] = x2;
    s.y1[k + 1] = y1;
    s.y2[k + 1] = y2;
    other = T(0.0);
  }
}

// Slip along c0 + c2 u^2 + rational/(1 + decay u).
template <class T>
void expand_rational(const Rig<T>& r, const Branch<T>& b, const Real<T>& dir, int order, Series<T>& s) {
  T u[series_size], den[series_size], q[series_size];
  const T scale = r.over_a1 * dir;
  u[0] = (s.x2[0] - r.v_b) * dir;
  den[0] = T(1.0) + b.decay * u[0];
  const T over_den = T(1.0) / den[0];
  q[0] = b.rational * over_den;
  for (int k = 0; k < order; ++k) {
    if (k > 0) {
      u[k] = s.x2[k] * dir;
      den[k] = b.decay * u[k];
      q[k] = quotient_next(T(0.0), den, q, over_den, k);
    }
    extend_positions(r, s, k);
    T friction = q[k] + b.c1 * u[k] + b.c2 * product(u, u, k);
    if (k == 0) friction = friction + b.c0;
    const T a = r.kx * s.x1[k] + bracket(r, s.x2[k], s.y1[k], s.y2[k]) * r.over_a1 + friction * scale;
    s.x2[k + 1] = -a * inverse<T>(k + 1);
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
