// Long stretches of the named rigs: the leg swings while the block sticks, or all of it where friction is linear in u.
#pragma once

#include "stickslip/piece.hpp"
#include "stickslip/stretch.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// The equation of the present mode, and its energy; friction T = level + slope x2 in slip.
template <class T>
void set_equation(const System<T>& sys, const Mode& mode, const State<T>& state, Stretch<T>& s) {
  const Rig<T>& r = sys.rig;
  const auto real = [](const T& x) { return Real<T>(value(x)); };
  for (int i = 0; i < 3 * s.m; ++i) s.f[i] = T(0.0);
  if (mode.contact == 0) {
    s.Q[0] = -(r.b3 * r.over_a2);
    s.R[0] = -(r.e12 * r.over_a2);
    s.f[0] = -((state.z[0] + r.e1 * r.v_b) * r.over_a2);
    s.f[1] = -(r.v_b * r.over_a2);
    s.W[0] = Real<T>(1.0);
    s.C[0] = -real(s.R[0]);
    s.K[0] = -real(s.Q[0]);
    s.w[0] = state.z[2];
    s.w[1] = state.z[3];
    return;
  }
  const Branch<T>& b = branch_of(sys, mode.contact);
  const T slope = mode.saturated ? T(0.0) : b.c1, magnitude = mode.saturated ? b.saturated : b.c0;
  const T damping = r.e1 + slope, level = magnitude * static_cast<double>(mode.contact) - slope * r.v_b;
  s.f[0] = -(level * r.over_a1);
  for (int i = 0; i < s.m; ++i) {
    s.w[i] = state.z[2 * i];
    s.w[s.m + i] = state.z[2 * i + 1];
  }
  const int last = s.m * s.m - 1;
  s.Q[0] = -r.kx;
  s.R[0] = -(damping * r.over_a1);
  s.W[0] = real(r.a1);
  s.K[0] = real(r.a1 * r.kx);
  s.C[0] = real(damping);
  if (!r.two) return;
  s.Q[1] = -(r.s * r.over_a1);
  s.Q[2] = -r.over_a2;
  s.Q[last] = -(r.b3 * r.over_a2);
  s.R[1] = -(r.e1 * r.over_a1);
  s.R[2] = -(r.e1 * r.over_a2);
  s.R[last] = -(r.e12 * r.over_a2);
  s.W[1] = s.W[2] = Real<T>(0.0);  // the leg's equation times s, so that K is symmetric
  s.W[last] = real(r.s / r.over_a2);
  s.K[1] = s.K[2] = real(r.s);
  s.K[last] = real(r.s * r.b3);
  s.C[1] = real(r.e1);
  s.C[2] = real(r.s * r.e1);
  s.C[last] = real(r.s * r.e12);
}

// Takes the state of a linear piece as far as no surface is met for certain, to four ordinary steps (`unit`; a turn
// of what swings, so that an observer sees the last) short of it and of `until`:
// how far, 0 if that is hardly worth it.
template <class T>
Real<T> cross(const System<T>& sys, const Mode& mode, const Watch<T>& watch, const Real<T>& unit, const Real<T>& until,
              State<T>& state) {
  using R = Real<T>;
  const Rig<T>& r = sys.rig;
  const bool stuck = mode.contact == 0;
  const R left = until - unit * last_steps;
  if (!(left > unit * worth_it) || (stuck && !r.two)) return R(0.0);
  T Q[4], damping[4], f[6], p[6], w[4], room[48];
  R W[4], C[4], K[4], real_room[8];
  Stretch<T> s{stuck || !r.two ? 1 : 2, Q, damping, f, p, w, room, W, C, K, real_room};
  set_equation(sys, mode, state, s);
  if (!split(s)) return R(0.0);
  R row[4] = {}, c0(0.0), c1(0.0);
  if (stuck) {  // q = a1 kx x1 + e1 (v_b + y2) + s y1
    row[0] = value(r.s);
    row[1] = value(r.e1);
    c0 = value(r.a1 * r.kx * state.z[0] + r.e1 * (r.v_b + p[1]) + r.s * p[0]);
    c1 = value(r.a1 * r.kx * r.v_b + r.s * p[1]);
  } else {  // x2, of whose polynomial nothing but 0 is left
    row[s.m] = R(1.0);
    c0 = value(p[s.m]);
  }
  const R reach = reach_of(s, row);
  R h = left;
  if (watch.has_lo) h = smallest(h, stays_above(R(c0 - value(watch.lo) - reach), c1, R(0.0), left));
  if (watch.has_hi) h = smallest(h, stays_above(R(value(watch.hi) - c0 - reach), R(-c1), R(0.0), left));
  if (h < left) h = h - largest(R(unit * last_steps), R(h * 1e-9));
  if (!(h > unit * worth_it)) return R(0.0);
  flow(s, h, unit);
  const T by(h);
  if (stuck) state.z[0] = state.z[0] + r.v_b * by;
  for (int i = 0; i < s.m; ++i) {
    const int to = stuck ? 2 : 2 * i;
    state.z[to] = place_at(s, i, by);
    state.z[to + 1] = speed_at(s, i, by);
  }
  state.t = state.t + by;
  return h;
}

}  // namespace stickslip::inline STICKSLIP_ISA
