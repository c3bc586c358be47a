// The recurrence of the coordinates.
#pragma once

#include "stickslip/bodies/modes.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Coefficient k + 1 of q' and q from the k-th, N coordinates (0: as many as there are).
template <int N, class T>
void motion_next(const BodiesSystem<T>& sys, const int* curved, int curved_count, int k) {
  const int n = N > 0 ? N : sys.n, columns = sys.columns;
  const Real<T> over = inverse<T>(k + 1);
  const int first_V = 2 * n + 1 + sys.speeds, first_T = first_V + sys.speeds;
  T q[N > 0 ? N : 1], v[N > 0 ? N : 1];
  if constexpr (N > 0)
    for (int i = 0; i < N; ++i) {
      q[i] = sys.q[i * series_size + k];
      v[i] = sys.v[i * series_size + k];
    }
  for (int i = 0; i < n; ++i) {
    const T* row = sys.projected + i * columns;
    T a(0.0), b(0.0);
    if (k == 0) a = row[2 * n];
    if constexpr (N > 0) {
      for (int c = 0; c < N; ++c) {
        add_product(a, row[c], q[c]);
        add_product(b, row[N + c], v[c]);
      }
    } else {
      for (int c = 0; c < n; ++c) {
        add_product(a, row[c], sys.q[c * series_size + k]);
        add_product(b, row[n + c], sys.v[c * series_size + k]);
      }
    }
    for (int s = 0; s < sys.speeds; ++s) {
      if (sys.pulled) add_product(a, row[2 * n + 1 + s], sys.x[s * series_size + k]);
      if (k == 0 || !sys.rail[s].steady) add_product(b, row[first_V + s], sys.V[s * series_size + k]);
    }
    for (int c = 0; c < curved_count; ++c)
      add_product(a, row[first_T + curved[c]], sys.force[curved[c] * series_size + k]);
    for (int h = 0; h < sys.stuck_count; ++h) {
      const int s = sys.contact[sys.stuck[h]].speed;
      if (s < 0 || sys.rail[s].steady) continue;
      add_product(b, sys.yields[i * sys.stuck_count + h], sys.V[s * series_size + k + 1] * static_cast<double>(k + 1));
    }
    sys.v[i * series_size + k + 1] = (a + b) * over;
    sys.q[i * series_size + k + 1] = sys.v[i * series_size + k] * over;
  }
}

// Friction that holds the stuck contacts, coefficient k: held row by row, less what the belt's acceleration takes.
template <class T>
T holding_force(const BodiesSystem<T>& sys, int h, const int* curved, int count, int k) {
  const int n = sys.n, first_V = 2 * n + 1 + sys.speeds;
  const T* row = sys.held + h * sys.columns;
  T s = k == 0 ? row[2 * n] : T(0.0);
  for (int c = 0; c < n; ++c) {
    add_product(s, row[c], sys.q[c * series_size + k]);
    add_product(s, row[n + c], sys.v[c * series_size + k]);
  }
  for (int i = 0; i < sys.speeds; ++i) {
    add_product(s, row[2 * n + 1 + i], sys.x[i * series_size + k]);
    add_product(s, row[first_V + i], sys.V[i * series_size + k]);
  }
  for (int c = 0; c < count; ++c)
    add_product(s, row[first_V + sys.speeds + curved[c]], sys.force[curved[c] * series_size + k]);
  for (int a = 0; a < sys.stuck_count; ++a) {
    const int speed = sys.contact[sys.stuck[a]].speed;
    if (speed < 0 || sys.rail[speed].steady) continue;
    add_product(s, -sys.stiff[h * sys.stuck_count + a],
                sys.V[speed * series_size + k + 1] * static_cast<double>(k + 1));
  }
  return s;
}

}  // namespace stickslip::inline STICKSLIP_ISA
