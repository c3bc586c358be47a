// One piece of a trajectory: its series, the surfaces that end it, and what happens at them.
#pragma once

#include "stickslip/effect_series.hpp"
#include "stickslip/expand.hpp"
#include "stickslip/switching.hpp"
#include "stickslip/system.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
struct Piece {
  Series<T> s;
  EffectSeries<T> fx;
  T q[series_size];
  T switching[watch_count][series_size];  // of a piece with effects
  Watch<T> watch[watch_count];
  int watches = 0;
};

template <class T>
T* state_series(Piece<T>& piece, int i) {
  T* visible[] = {piece.s.x1, piece.s.x2, piece.s.y1, piece.s.y2};
  return i < visible_count ? visible[i] : piece.fx.hidden[i - visible_count];
}

template <class T>
Real<T> natural_frequency(const System<T>& sys) {
  return sys.frequency;
}

// The scale of a motion: its speeds, and its positions as speeds.
template <class T>
Real<T> motion_scale(const System<T>& sys, const Series<T>& s) {
  using R = Real<T>;
  const R position = largest(R(magnitude(value(s.x1[0]))), R(magnitude(value(s.y1[0]))));
  const R speed = largest(R(magnitude(value(s.x2[0]))), R(magnitude(value(s.y2[0]))));
  return largest(speed, R(position * natural_frequency(sys)));
}

// Without effects a piece has one switching function: q between the static limits, or u from 0 to the kink.
template <class T>
int expand_plain(const System<T>& sys, const Mode& mode, int curve_order, Piece<T>& piece, Real<T>& linear_step) {
  const Rig<T>& r = sys.rig;
  Series<T>& s = piece.s;
  Watch<T>& watch = piece.watch[0];
  piece.watches = 1;
  watch.id = watch_contact;
  watch.rounding = Real<T>(0.0);
  watch.has_lo = watch.has_hi = true;
  linear_step = sys.line_step;
  if (mode.contact == 0) {
    linear_step = sys.stick_step;
    expand_stick(r, linear_order, s, piece.q);
    watch.c = piece.q;
    watch.lo = -sys.plus.static_limit;
    watch.hi = sys.minus.static_limit;
    watch.rounding = value(watch.hi - watch.lo) * limit_rounding;
    return linear_order;
  }
  const Branch<T>& b = branch_of(sys, mode.contact);
  const Real<T> dir(static_cast<double>(mode.contact));
  int order = linear_order;
  if (mode.saturated) {
    linear_step = sys.floor_step;
    expand_line(r, b.saturated, T(0.0), dir, order, s);
  } else if (b.curve == straight) {
    expand_line(r, b.c0, b.c1, dir, order, s);
  } else {
    linear_step = Real<T>(0.0);
    order = curve_order;
    with_curve(b, [&]<class L> { expand_curve<L>(r, b, dir, order, s); });
  }
  watch.c = s.x2;  // x2 = v_b + dir u, so that u = 0 and u = kink are bounds on x2 itself
  const T far = r.v_b + b.kink * dir;
  const bool curve = !mode.saturated;
  if (mode.contact > 0) {
    watch.lo = curve ? r.v_b : far;
    watch.hi = far;
    watch.has_hi = b.has_kink && curve;
  } else {
    watch.hi = curve ? r.v_b : far;
    watch.lo = far;
    watch.has_lo = b.has_kink && curve;
  }
  return order;
}

// The block has come to rest on the belt with the given margins of q to the static limits: does it stay? On a limit, to
// rounding, it does, and then stands on that surface: where q goes next decides, not the last digit.
inline int contact_at_rest(double upper_margin, double lower_margin, double limit, Side& stands) {
  stands = Side::none;
  if (upper_margin < -limit_rounding * limit) return -1;
  if (lower_margin < -limit_rounding * limit) return 1;
  if (upper_margin <= limit_rounding * limit) stands = Side::upper;
  if (lower_margin <= limit_rounding * limit) stands = Side::lower;
  return 0;
}

template <class T>
void change_plain(const System<T>& sys, State<T>& s, Mode& mode, Side* on, Side side) {
  const Side towards_rest = mode.contact > 0 ? Side::lower : Side::upper;
  const bool slip_end = mode.contact != 0 && side == towards_rest && !mode.saturated;
  if (mode.contact != 0 && !slip_end) {  // the branch saturates, or leaves its floor
    mode.saturated = !mode.saturated;
    on[watch_contact] = opposite(side);
    return;
  }
  if (slip_end) {
    s.z[1] = sys.rig.v_b;
    const T q = demand(sys.rig, s.z[0], s.z[1], s.z[2], s.z[3]);
    const auto real = [](const T& x) { return static_cast<double>(value(x)); };
    mode.contact = contact_at_rest(real(sys.minus.static_limit - q), real(sys.plus.static_limit + q),
                                   real(sys.minus.static_limit + sys.plus.static_limit), on[watch_contact]);
  } else {
    mode.contact = side == Side::upper ? -1 : 1;
  }
  mode.saturated = false;
  if (mode.contact != 0) on[watch_contact] = mode.contact > 0 ? Side::lower : Side::upper;
}

}  // namespace stickslip::inline STICKSLIP_ISA
