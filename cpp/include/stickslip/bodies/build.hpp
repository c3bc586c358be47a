// What follows from the numbers of a rig of bodies once and for all.
#pragma once

#include "stickslip/bodies/system.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// What follows from the numbers once and for all: M^-1, the free rig, whether anything is pulled.
template <class T>
void build(BodiesSystem<T>& sys) {
  const int n = sys.n;
  for (int k = 0; k < series_size; ++k) sys.time[k] = T(k == 1 ? 1.0 : 0.0);
  for (int k = 0; k < sys.contacts * series_size; ++k) sys.dwell[k] = T(0.0);
  for (int i = 0; i < n * n; ++i) sys.room[i] = sys.values[sys.at.M + i];
  invert(sys.room, sys.inverse, n);
  for (int i = 0; i < n; ++i) sys.weight[i] = square_root(magnitude(value(sys.values[sys.at.M + i * (n + 1)])));
  const auto put = [&](int column, const T* force, int stride, double sign) {  // M^-1 of a column of forces
    for (int i = 0; i < n; ++i) {
      T s(0.0);
      for (int k = 0; k < n; ++k) add_product(s, sys.inverse[i * n + k], force[k * stride]);
      sys.free[i * sys.columns + column] = s * sign;
    }
  };
  for (int c = 0; c < n; ++c) {
    put(c, sys.values + sys.at.K + c, n, -1.0);
    put(n + c, sys.values + sys.at.C + c, n, -1.0);
  }
  put(2 * n, sys.values + sys.at.force, 1, 1.0);
  sys.pulled = false;
  for (int s = 0; s < sys.speeds; ++s) {
    const T *by_x = sys.values + sys.at.pull_x + s * n, *by_v = sys.values + sys.at.pull_v + s * n;
    put(2 * n + 1 + s, by_x, 1, 1.0);
    put(2 * n + 1 + sys.speeds + s, by_v, 1, 1.0);
    for (int i = 0; i < n; ++i)
      sys.pulled = sys.pulled || !is_plain(by_x[i]) || !is_plain(by_v[i]) || value(by_x[i]) != 0 || value(by_v[i]) != 0;
  }
  for (int i = 0; i < n * n; ++i) sys.room[i] = sys.free[i / n * sys.columns + i % n];
  sys.frequency = square_root(eigenvalue_bound(sys.room, sys.weight, n));
  for (int j = 0; j < sys.contacts; ++j) {
    put(2 * n + 1 + 2 * sys.speeds + j, sys.D(j), 1, -1.0);
    for (int i = 0; i < n; ++i) sys.reach[j * n + i] = -sys.free[i * sys.columns + 2 * n + 1 + 2 * sys.speeds + j];
  }
  for (int e = 0; e < sys.pushes; ++e) {
    put(2 * n + 1 + 2 * sys.speeds + sys.contacts + e, sys.G(e), 1, 1.0);
    for (int i = 0; i < n; ++i)
      sys.push[e].moves = sys.push[e].moves || !is_plain(sys.G(e)[i]) || value(sys.G(e)[i]) != 0;
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
