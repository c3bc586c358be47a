// The recurrence of the coordinates where it is short: steady speeds, laws without states, one curved law at most. All that
// does not change from order to order stands in registers.
#pragma once

#include "stickslip/bodies/motion.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Is it? `curved`: the contacts whose force is curved.
template <class T>
bool is_short(const BodiesSystem<T>& sys, int curved_count) {
  if (curved_count > 1 || sys.states > 0 || sys.pushes > 0) return false;
  for (int s = 0; s < sys.speeds; ++s)
    if (!sys.rail[s].steady) return false;
  return true;
}

// N coordinates; the contact `curved` has a law of its own, where it is one.
template <int N, bool Curved, class T>
void expand_short(BodiesSystem<T>& sys, int curved, int order) {
  const int first_V = 2 * N + 1 + sys.speeds;
  T K[N][N], C[N][N], load[N], drift[N], by_force[N], D[N], q[N], v[N];
  Contact<T>& c = sys.contact[Curved ? curved : 0];
  Tape<T>& tape = tape_of(c);
  const T* force = nullptr;
  T* u = sys.u + curved * series_size;
  T* kept = sys.force + curved * series_size;
  double sign = 1, direction = 0;
  if constexpr (Curved) {
    force = tape.node[source(tape, tape.formulas->force)].c;
    sign = c.compliant[c.mode > 0] ? 1.0 : c.mode;
    direction = c.mode;
  }
  for (int i = 0; i < N; ++i) {
    const T* row = sys.projected + i * sys.columns;
    load[i] = row[2 * N];
    drift[i] = T(0.0);
    for (int s = 0; s < sys.speeds; ++s) {
      add_product(load[i], row[2 * N + 1 + s], sys.x[s * series_size]);
      add_product(load[i], row[first_V + s], sys.V[s * series_size]);
      add_product(drift[i], row[2 * N + 1 + s], sys.V[s * series_size]);
    }
    for (int k = 0; k < N; ++k) {
      K[i][k] = row[k];
      C[i][k] = row[N + k];
    }
    if constexpr (Curved) {
      by_force[i] = row[first_V + sys.speeds + curved];
      D[i] = sys.D(curved)[i];
    }
    q[i] = sys.q[i * series_size];
    v[i] = sys.v[i * series_size];
  }
  for (int k = 0; k < order; ++k) {
    const Real<T> over = inverse<T>(k + 1);
    T push(0.0);
    if constexpr (Curved) {
      T slip(0.0);
      for (int i = 0; i < N; ++i) add_product(slip, D[i], v[i]);
      if (k == 0 && c.speed >= 0) slip = slip - sys.V[c.speed * series_size];
      u[k] = k == 0 && c.leaving ? T(0.0) : slip * direction;
      run(tape.inner, tape.inners, k);
      push = force[k] * sign;
      kept[k] = push;
    }
    T next[N];
    for (int i = 0; i < N; ++i) {
      T a = load[i], b = C[i][0] * v[0];
      add_product(a, K[i][0], q[0]);
      for (int j = 1; j < N; ++j) {
        add_product(a, K[i][j], q[j]);
        add_product(b, C[i][j], v[j]);
      }
      if constexpr (Curved) add_product(b, by_force[i], push);
      next[i] = (a + b) * over;
      load[i] = k == 0 ? drift[i] : T(0.0);
    }
    for (int i = 0; i < N; ++i) {
      q[i] = v[i] * over;
      v[i] = next[i];
      sys.q[i * series_size + k + 1] = q[i];
      sys.v[i * series_size + k + 1] = v[i];
    }
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
