// Surfaces: which there are, and what a trajectory must stay within.
#pragma once

#include "stickslip/rig.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// One number a kind of surface; a trajectory that has just left one remembers on which side it stands.
enum WatchId : int {
  watch_contact = 0,  // stick: q within the static limits (with effects: the margin at the upper one); slip: u > 0
  watch_demand,       // with effects: the margin at the lower static limit
  watch_kink,
  effect_watches  // from here on those of effects
};
constexpr int watch_count = effect_watches + surface_count;
template <class E>
constexpr int effect_watch = effect_watches + surface_of<E>;

constexpr double limit_rounding = 1e-13;  // a force this near to a static limit, as a share of both limits, is on it

template <class T>
struct Watch {
  const T* c;  // coefficients, kept elsewhere in the piece
  T lo, hi;
  Real<T> rounding{};  // differences of c below this are rounding: who stands on a bound and moves less, stays on it
  bool has_lo = false, has_hi = false;
  int id = watch_contact;
};

template <class T>
void above(Watch<T>& w, const T& bound) {
  w.has_lo = true;
  w.lo = bound;
}
template <class T>
void below(Watch<T>& w, const T& bound) {
  w.has_hi = true;
  w.hi = bound;
}

// Which bound a trajectory stands on and is leaving.
enum class Side : signed char { lower = -1, none = 0, upper = 1 };
constexpr Side opposite(Side side) { return side == Side::lower ? Side::upper : Side::lower; }

}  // namespace stickslip::inline STICKSLIP_ISA
