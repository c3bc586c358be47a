// One piece of a trajectory: its series, the surfaces that end it, and what happens at them.
#pragma once

#include "stickslip/switching.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
struct System {
  Parameters<T> p;
  Rig<T> rig;
  Branch<T> minus, plus;
  Structure structure;
  T table[max_knots + 1][4];  // cubic of each interval in (variable - its left knot); constant outside the knots
};

template <class T>
void build(System<T>& sys) {  // from sys.structure and sys.p
  sys.rig = make_rig(sys.structure.rig, sys.p);
  sys.minus = branch(sys.structure.law, sys.p, -1);
  sys.plus = branch(sys.structure.law, sys.p, 1);
}

template <class T>
const Branch<T>& branch_of(const System<T>& sys, int contact) {
  return contact < 0 ? sys.minus : sys.plus;
}

// Coefficients of what effects bring along, one array a quantity; only those of active effects are ever touched.
template <class T>
struct EffectSeries {
  T w[series_size], z[series_size], b[series_size], m[series_size];   // hidden states
  T belt[series_size], ripple[series_size], ripple_cos[series_size];  // V(t); v_b a sin(w t + phi) and its cosine
  T v[series_size], u[series_size], friction[series_size], magnitude[series_size], kinetic[series_size];
  T slope[series_size], e1[series_size], e2[series_size];
  T square[series_size], peak_slope[series_size], peak[series_size];
  T factor[4][series_size], normal[series_size], drift[series_size], seam_slope[series_size], seam[series_size],
      seam_cos[series_size];
  T aging[series_size], limit_minus[series_size], limit_plus[series_size];
  T forcing[series_size], forcing_cos[series_size];
  T x1_square[series_size], x2_square[series_size], y1_square[series_size], sum[series_size], sum_square[series_size];
  T zv[series_size], ratio[series_size], pivot_force[series_size];
  T table[series_size], variable[series_size], variable2[series_size], variable3[series_size];
};

template <class T>
struct Piece {
  Series<T> s;
  EffectSeries<T> fx;
  Watch<T> watch[watch_count];
  int watches = 0;
};

// A linear piece is expanded to machine precision whatever the tolerance: its series is cheap.
constexpr int linear_order = 20;
constexpr double linear_tolerance = 1e-17;

template <class T>
T* state_series(Piece<T>& piece, int i) {
  T* all[] = {piece.s.x1, piece.s.x2, piece.s.y1, piece.s.y2, piece.fx.w, piece.fx.z, piece.fx.b, piece.fx.m};
  return all[i];
}

template <class T>
Real<T> natural_frequency(const System<T>& sys) {
  return square_root(Real<T>(value(sys.rig.kx)));
}

// Longest step whose first neglected terms stay below the tolerance (Jorba and Zou 2005), from the last two.
template <class T>
Real<T> step_from(const Real<T>& last, const Real<T>& before, const Real<T>& scale, int order, double rtol,
                  double atol) {
  using R = Real<T>;
  const R tiny(1e-300);
  const R allowed = rough_log2(R(atol) + R(rtol) * scale + tiny);
  const R h1 = (allowed - rough_log2(last + tiny)) * (1.0 / order);
  const R h2 = (allowed - rough_log2(before + tiny)) * (1.0 / (order - 1));
  const R safety(-0.7 / (order - 1) * 1.4426950408889634);
  return exponential(((h1 < h2 ? h1 : h2) + safety) * 0.6931471805599453);
}

template <class T>
Real<T> step_length(const System<T>& sys, const Piece<T>& piece, int order, bool linear, double rtol, double atol) {
  using R = Real<T>;
  const Series<T>& s = piece.s;
  const auto size = [&](int k) { return largest(R(magnitude(value(s.x2[k]))), R(magnitude(value(s.y2[k])))); };
  const R position = largest(R(magnitude(value(s.x1[0]))), R(magnitude(value(s.y1[0]))));
  const R scale = largest(size(0), R(position * natural_frequency(sys)));
  if (linear) return step_from<T>(size(order), size(order - 1), scale, order, linear_tolerance, 0.0);
  return step_from<T>(size(order), size(order - 1), scale, order, rtol, atol);
}

// Without effects a piece has one switching function: q between the static limits, or u from 0 to the kink.
template <class T>
int expand_plain(const System<T>& sys, const Mode& mode, int curve_order, Piece<T>& piece, bool& linear) {
  const Rig<T>& r = sys.rig;
  Series<T>& s = piece.s;
  Watch<T>& watch = piece.watch[0];
  piece.watches = 1;
  watch.id = watch_contact;
  watch.has_lo = watch.has_hi = true;
  linear = true;
  if (mode.contact == 0) {
    expand_stick(r, linear_order, s);
    for (int k = 0; k <= linear_order; ++k) watch.c[k] = demand(r, s.x1[k], s.x2[k], s.y1[k], s.y2[k]);
    watch.lo = -sys.plus.static_limit;
    watch.hi = sys.minus.static_limit;
    return linear_order;
  }
  const Branch<T>& b = branch_of(sys, mode.contact);
  const Real<T> dir(static_cast<double>(mode.contact));
  int order = linear_order;
  if (mode.saturated) {
    expand_line(r, b.saturated, T(0.0), dir, order, s);
  } else if (b.shape == Shape::line) {
    expand_line(r, b.c0, b.c1, dir, order, s);
  } else {
    linear = false;
    order = curve_order;
    if (b.shape == Shape::exponentials) {
      expand_curve<Shape::exponentials>(r, b, dir, order, s);
    } else {
      expand_curve<Shape::rational>(r, b, dir, order, s);
    }
  }
  for (int k = 0; k <= order; ++k) watch.c[k] = s.x2[k] * dir;
  watch.c[0] = (s.x2[0] - r.v_b) * dir;
  watch.lo = mode.saturated ? b.kink : T(0.0);
  watch.has_hi = b.has_kink && !mode.saturated;
  watch.hi = b.kink;
  return order;
}

// The block has come to rest on the belt: does it stay?
template <class T>
int contact_at_rest(const T& q, const T& lower, const T& upper) {
  if (value(q) > value(upper)) return -1;
  return value(q) < value(lower) ? 1 : 0;
}

template <class T>
void change_plain(const System<T>& sys, State<T>& s, Mode& mode, Side* on, Side side) {
  const bool slip_end = mode.contact != 0 && side == Side::lower && !mode.saturated;
  if (mode.contact != 0 && !slip_end) {  // the branch saturates, or leaves its floor
    mode.saturated = side == Side::upper;
    on[watch_contact] = mode.saturated ? Side::lower : Side::upper;
    return;
  }
  if (slip_end) {
    s.z[1] = sys.rig.v_b;
    const T q = demand(sys.rig, s.z[0], s.z[1], s.z[2], s.z[3]);
    mode.contact = contact_at_rest(q, T(-sys.plus.static_limit), sys.minus.static_limit);
  } else {
    mode.contact = side == Side::upper ? -1 : 1;
  }
  mode.saturated = false;
  if (mode.contact != 0) on[watch_contact] = Side::lower;
}

}  // namespace stickslip::inline STICKSLIP_ISA
