// The series of a piece of (2.1): stick, slip along a line, along the curve of a law.
#pragma once

#include "stickslip/rig.hpp"

namespace stickslip::inline STICKSLIP_ISA {

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

// Slip along the curve of the law L, with the law's own loop where it has one.
template <class L, class T>
void expand_curve(const Rig<T>& r, const Branch<T>& b, const Real<T>& dir, int order, Series<T>& s) {
  if constexpr (requires { L::expand(r, b, dir, order, s); }) {
    L::expand(r, b, dir, order, s);
  } else {
    T u[series_size];
    typename L::template Series<T> own;
    const T scale = r.over_a1 * dir;
    for (int k = 0; k < order; ++k) {
      u[k] = (k == 0 ? s.x2[0] - r.v_b : s.x2[k]) * dir;
      extend_positions(r, s, k);
      const T friction = constant(b.c0, k) + b.c1 * u[k] + L::next(b.own, u, own, k);
      const T a = r.kx * s.x1[k] + bracket(r, s.x2[k], s.y1[k], s.y2[k]) * r.over_a1 + friction * scale;
      s.x2[k + 1] = -a * inverse<T>(k + 1);
    }
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
