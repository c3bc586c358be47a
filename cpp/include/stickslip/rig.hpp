// (2.1) and the block on a belt as one linear vector field.
//
//   x1' = x2     x2' = -kx x1 - (e1 (x2 + y2) + s y1 + T) / a1      T = sgn(v_w) R(|v_w|), v_w = x2 - v_b
//   y1' = y2     y2' = (-b3 y1 - e12 y2 - x1 - e1 x2) / a2
// with kx = 1 + stiffness/a1 for the rig; the block on a belt has no y, kx = stiffness/mass, a1 = mass,
// e1 = damping.
#pragma once

#include "stickslip/friction.hpp"
#include "stickslip/mode.hpp"
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
  r.kx = r.two ? T(1.0) + p[stiffness] * r.over_a1 : p[stiffness] * r.over_a1;
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

template <class T>
struct State {
  T z[state_count];
  T t;
};

template <class T>
struct Series {
  T x1[series_size], x2[series_size], y1[series_size], y2[series_size];
};

}  // namespace stickslip::inline STICKSLIP_ISA
