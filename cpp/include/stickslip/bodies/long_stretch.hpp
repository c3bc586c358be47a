// Long stretches of a rig of bodies whose present modes are linear.
#pragma once

#include "stickslip/bodies/free_motion.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// How long contact j surely keeps its mode and its piece, at most `most`; `path` holds the polynomial of q.
template <class T>
Real<T> surely_kept(const BodiesSystem<T>& sys, BodiesStretch<T>& b, int j, const Real<T>& most) {
  using R = Real<T>;
  const int n = sys.n, m = b.s.m;
  const Contact<T>& c = sys.contact[j];
  int h = 0;
  while (h < sys.stuck_count && sys.stuck[h] != j) ++h;
  const bool stuck = c.mode == sticks;
  const T* held = sys.held + h * sys.columns;
  R poly[3] = {};
  for (int i = 0; i < 2 * m; ++i) b.row[i] = R(0.0);
  for (int i = 0; i < m; ++i)
    for (int k = 0; k < n; ++k) {
      const R by = value(b.N[k * m + i]);
      if (stuck) b.row[i] += value(held[k]) * by;
      b.row[m + i] += (stuck ? value(held[n + k]) : value(sys.D(j)[k]) * static_cast<double>(c.mode)) * by;
    }
  for (int k = 0; k < 3; ++k) {
    if (stuck) {
      poly[k] = value(along(sys, held, b.path, k));
    } else if (k < 2) {
      for (int i = 0; i < n; ++i) poly[k] += value(sys.D(j)[i]) * value(b.path[(k + 1) * n + i]) * (k + 1.0);
      if (c.speed >= 0) poly[k] -= value(sys.V[c.speed * series_size + k]);
      poly[k] = poly[k] * static_cast<double>(c.mode);
    }
  }
  for (int a = 0; stuck && a < sys.stuck_count; ++a)
    if (const int speed = sys.contact[sys.stuck[a]].speed; speed >= 0)
      poly[0] -= value(sys.stiff[h * sys.stuck_count + a]) * value(sys.V[speed * series_size + 1]);
  const R reach = reach_of(b.s, b.row);
  const auto limit = [&](int side) { return R(value(coefficient(c.tape[side], c.tape[side].formulas->limit, 0))); };
  const R lo = stuck ? R(-limit(0)) : R(value(c.interval.lo)), hi = stuck ? limit(1) : R(value(c.interval.hi));
  R out = stays_above(R(poly[0] - lo - reach), poly[1], poly[2], most);
  if (stuck || c.interval.has_hi)
    out = smallest(out, stays_above(R(hi - poly[0] - reach), R(-poly[1]), R(-poly[2]), most));
  return out;
}

// As cross() of the named rigs. The series of the piece that starts here are expanded.
template <class T>
Real<T> cross(const BodiesSystem<T>& sys, BodiesStretch<T>& b, const Real<T>& unit, const Real<T>& until,
              BodiesState<T>& state) {
  using R = Real<T>;
  Stretch<T>& s = b.s;
  const int n = sys.n;
  const R left = until - unit * last_steps, worth = unit * (worth_it * n);
  if (!(left > worth) || sys.stuck_count == n) return R(0.0);
  span_free(sys, b);
  set_equation(sys, state, b);
  if (!split(s)) return R(0.0);
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < s.m; ++j) add_product(b.path[k * n + i], b.N[i * s.m + j], s.p[k * s.m + j]);
  R h = left;
  for (int j = 0; j < sys.contacts; ++j) h = surely_kept(sys, b, j, h);
  if (h < left) h = h - largest(R(unit * last_steps), R(h * 1e-9));
  if (!(h > worth)) return R(0.0);
  flow(s, h, unit);
  const T by(h);
  for (int i = 0; i < n; ++i) {
    T q = b.path[i] + by * (b.path[n + i] + by * b.path[2 * n + i]), v = b.path[n + i] + by * b.path[2 * n + i] * 2.0;
    for (int j = 0; j < s.m; ++j) {
      add_product(q, b.N[i * s.m + j], s.w[j]);
      add_product(v, b.N[i * s.m + j], s.w[s.m + j]);
    }
    state.z[i] = q;
    state.z[n + i] = v;
  }
  for (int i = 0; i < sys.speeds; ++i) {
    const T* x = sys.x + i * series_size;
    state.z[2 * n + sys.states + i] = x[0] + by * (x[1] + by * x[2]);
  }
  state.t = state.t + by;
  return h;
}

}  // namespace stickslip::inline STICKSLIP_ISA
