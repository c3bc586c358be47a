// Switching functions of a piece, as polynomials with an interval they must stay in.
#pragma once

#include "stickslip/henon.hpp"
#include "stickslip/rig.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// One row a kind of surface; a trajectory that has just left one remembers on which side it stands.
enum WatchId : int {
  watch_contact = 0,  // stick: q within the static limits (with effects: the margin at the upper one); slip: u > 0
  watch_demand,       // with effects: the margin at the lower static limit
  watch_kink,
  watch_x2,
  watch_gap,
  watch_pivot,
  watch_lift,
  watch_memory,
  watch_table,
  watch_count
};

template <class T>
struct Watch {
  T c[series_size];
  T lo, hi;
  bool has_lo = false, has_hi = false;
  int id = watch_contact;
};

// Which bound a trajectory stands on and is leaving.
enum class Side : signed char { lower = -1, none = 0, upper = 1 };

template <class T>
struct Exit {
  bool found = false;
  Real<T> t{};    // time since the start of the piece
  int watch = 0;  // index in the piece's list
  Side side = Side::none;
};

// t of the crossing in the number type: one Newton step on the implicit equation S(t, p) = 0 gives dt/dp.
template <class T>
T with_derivatives(const T* c, const T& bound, int order, const Real<T>& t) {
  if constexpr (requires(T x) { x.d[0]; }) {
    const T s = evaluate(c, order, t) - bound;
    const double slope = value(evaluate_slope(c, order, t));
    T r(t);
    if (slope != 0)
      for (int i = 0; i < T::size; ++i) r.d[i] = -s.d[i] / slope;
    return r;
  } else {
    return t;
  }
}

// A series at a time that itself carries derivatives: first-order expansion about its value, which is exact here.
template <class T>
T evaluate_at(const T* c, int order, const T& h) {
  if constexpr (requires(T x) { x.d[0]; }) {
    T r = evaluate(c, order, h.v);
    double slope = 0;
    for (int k = order; k >= 1; --k) slope = slope * h.v + c[k].v * k;
    for (int i = 0; i < T::size; ++i) r.d[i] += slope * h.d[i];
    return r;
  } else {
    return evaluate(c, order, h);
  }
}

// The earliest exit of all watches within (0, h]; ties go to the first in the list.
template <class T>
Exit<T> first_exit(const Watch<T>* watches, int count, int order, Real<T> h, const Side* on, bool henon) {
  using R = Real<T>;
  Exit<T> best;
  for (int w = 0; w < count; ++w) {
    for (const Side side : {Side::lower, Side::upper}) {
      const Watch<T>& watch = watches[w];
      if (!(side == Side::lower ? watch.has_lo : watch.has_hi)) continue;
      R c[series_size];
      const R sign(side == Side::lower ? 1.0 : -1.0);
      for (int k = 0; k <= order; ++k) c[k] = sign * value(watch.c[k]);
      c[0] -= sign * value(side == Side::lower ? watch.lo : watch.hi);
      const bool leaving = on[watch.id] == side;
      if (leaving) c[0] = R(0.0);
      R t{};
      if (!first_crossing(c, order, h, leaving, henon, t)) continue;
      if (!best.found || t < best.t) {
        best.found = true;
        best.t = t;
        best.watch = w;
        best.side = side;
        h = t;
      }
    }
  }
  return best;
}

}  // namespace stickslip::inline STICKSLIP_ISA
