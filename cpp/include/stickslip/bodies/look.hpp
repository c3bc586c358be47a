// The state of a rig of bodies, and its forces now.
#pragma once

#include "stickslip/bodies/onset.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
struct BodiesState {
  T* z;  // q, q', states of laws, x
  T t;
};

// The first coefficients of all series.
template <class T>
void set_first(BodiesSystem<T>& sys, const BodiesState<T>& s) {
  const int n = sys.n;
  for (int i = 0; i < n; ++i) {
    sys.q[i * series_size] = s.z[i];
    sys.v[i * series_size] = s.z[n + i];
  }
  for (int i = 0; i < sys.states; ++i) sys.z[i * series_size] = s.z[2 * n + i];
  for (int i = 0; i < sys.speeds; ++i) sys.x[i * series_size] = s.z[2 * n + sys.states + i];
  sys.time[0] = s.t;
  for (int j = 0; j < sys.contacts; ++j) {
    T* dwell = sys.dwell + j * series_size;
    const bool stuck = sys.contact[j].mode == sticks;
    dwell[0] = stuck ? s.t - sys.contact[j].since : T(0.0);
    dwell[1] = T(stuck ? 1.0 : 0.0);
  }
}

// The state h after the start of the piece.
template <class T>
void bodies_state(const BodiesSystem<T>& sys, const T& h, int order, T* z) {
  const int moving = 2 * sys.n + sys.states;
  const auto series = [&](int i) {
    const int n = sys.n;
    return i < n ? sys.q + i * series_size
                 : (i < 2 * n ? sys.v + (i - n) * series_size : sys.z + (i - 2 * n) * series_size);
  };
  int i = 0;
  if constexpr (std::is_floating_point_v<T>)  // in fours that do not wait for each other
    for (; i + 4 <= moving && order >= 2; i += 4)
      evaluate_four<T>({series(i), series(i + 1), series(i + 2), series(i + 3)}, order, h, z + i);
  for (; i < moving; ++i) z[i] = evaluate_at(series(i), order, h);
  for (int k = 0; k < sys.speeds; ++k) {
    const T* x = sys.x + k * series_size;
    z[moving + k] = sys.rail[k].steady ? x[0] + x[1] * h : evaluate_at(x, order, h);
  }
}

// A sum that is finite where all of the state is.
template <class T>
Real<T> sum_of(const BodiesSystem<T>& sys, const BodiesState<T>& s) {
  Real<T> sum = value(s.t);
  for (int i = 0; i < sys.at.state; ++i) sum += value(s.z[i]);
  return sum;
}

// v of a contact, by the present velocities and speeds.
template <class T>
T relative_speed(const BodiesSystem<T>& sys, const BodiesState<T>& s, int j) {
  T v = dot(sys.D(j), s.z + sys.n, sys.n);
  const int speed = sys.contact[j].speed;
  return speed < 0 ? v : v - sys.V[speed * series_size];
}

// Takes rounding off: what sticks moves with what it sticks to.
template <class T>
void follow(BodiesSystem<T>& sys, BodiesState<T>& s) {
  const int held = sys.stuck_count, n = sys.n;
  for (int a = 0; a < held; ++a) sys.room[a] = relative_speed(sys, s, sys.stuck[a]);
  for (int i = 0; i < n; ++i)
    for (int a = 0; a < held; ++a) s.z[n + i] = s.z[n + i] - sys.yields[i * held + a] * sys.room[a];
}

// Links everything for the present modes and looks at the forces now.
template <class T>
void look(BodiesSystem<T>& sys, BodiesState<T>& s) {
  set_first(sys, s);
  link_speeds(sys);
  expand_speeds(sys, 1);
  for (int j = 0; j < sys.contacts; ++j) {
    if (sys.contact[j].mode != sticks) sys.u[j * series_size] = speed_coefficient(sys, j, 0);
    link_contact(sys, j);
  }
  for (int e = 0; e < sys.pushes; ++e) link_push(sys, e);
  hold(sys);
  follow(sys, s);
  set_first(sys, s);
  expand_bodies(sys, 1);
}

}  // namespace stickslip::inline STICKSLIP_ISA
