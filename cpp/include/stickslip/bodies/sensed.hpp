// What sensors read of a rig of bodies beside its state: accelerations, friction, the forces of effects, prescribed speeds.
#pragma once

#include "stickslip/bodies/look.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// h after the start of a piece, where the state is z: q'' (n), T of the contacts, F of the pushes, V of the speeds. At
// a transition the piece is the one after it: accelerations and friction are those after the jump.
template <class T>
void sense(const BodiesSystem<T>& sys, const T& h, int order, const T* z, T* out) {
  const int n = sys.n, m = sys.contacts, first_V = 2 * n + 1 + sys.speeds, first_T = first_V + sys.speeds;
  T *friction = out + n, *push = friction + m, *V = push + sys.pushes;
  const T *q = z, *v = z + n, *x = z + 2 * n + sys.states;
  for (int s = 0; s < sys.speeds; ++s) {
    const T* c = sys.V + s * series_size;
    V[s] = sys.rail[s].steady ? c[0] : evaluate_at(c, order, h);
  }
  for (int e = 0; e < sys.pushes; ++e)
    push[e] = sys.push[e].moves ? evaluate_at(sys.force + (m + e) * series_size, order, h) : T(0.0);
  for (int j = 0; j < m; ++j)
    friction[j] = sys.contact[j].linear ? T(0.0) : evaluate_at(sys.force + j * series_size, order, h);
  const auto along = [&](const T* row) {  // a row of `projected` or `held` now; friction that is linear in v is in them
    T s = row[2 * n];
    for (int k = 0; k < n; ++k) {
      add_product(s, row[k], q[k]);
      add_product(s, row[n + k], v[k]);
    }
    for (int k = 0; k < sys.speeds; ++k) {
      add_product(s, row[2 * n + 1 + k], x[k]);
      add_product(s, row[first_V + k], V[k]);
    }
    for (int k = 0; k < m + sys.pushes; ++k) add_product(s, row[first_T + k], k < m ? friction[k] : push[k - m]);
    return s;
  };
  const auto gains = [&](int a) {  // V' of what a stuck contact rubs on
    const int s = sys.contact[sys.stuck[a]].speed;
    return s < 0 || sys.rail[s].steady ? T(0.0) : evaluate_slope(sys.V + s * series_size, order + 1, h);
  };
  for (int i = 0; i < n; ++i) {
    out[i] = along(sys.projected + i * sys.columns);
    for (int a = 0; a < sys.stuck_count; ++a) add_product(out[i], sys.yields[i * sys.stuck_count + a], gains(a));
  }
  T held[most_forces];
  for (int b = 0; b < sys.stuck_count; ++b) {
    held[b] = along(sys.held + b * sys.columns);
    for (int a = 0; a < sys.stuck_count; ++a) add_product(held[b], -sys.stiff[b * sys.stuck_count + a], gains(a));
  }
  for (int b = 0; b < sys.stuck_count; ++b) friction[sys.stuck[b]] = held[b];
  for (int j = 0; j < m; ++j) {
    const Contact<T>& c = sys.contact[j];
    if (c.mode == sticks || !c.linear) continue;
    const T speed = dot(sys.D(j), v, n);
    friction[j] = c.level + c.slope * (c.speed < 0 ? speed : speed - V[c.speed]);
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
