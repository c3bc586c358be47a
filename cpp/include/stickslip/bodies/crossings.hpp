// Surfaces of a formula that hang on u alone, as bounds on u: where max(f(u), floor) goes over is found once, by ranges,
// which show that nothing is left out. Such a surface need not be expanded and watched.
#pragma once

#include "stickslip/bodies/range.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr int most_range_looks = 400;  // of the search of one surface; past that it is watched as a series

// Marks what the surface of node i is made of; false if that is more than u and numbers.
template <class T>
bool mark_surface(Tape<T>& tape, int i) {
  for (int k = 0; k < i; ++k) tape.marks[k] = false;
  tape.marks[tape.at(i).a] = true;
  if (is_binary(tape.at(i).op)) tape.marks[tape.at(i).b] = true;
  for (int k = i - 1; k >= 0; --k) {
    const Node& one = tape.at(k);
    if (!tape.marks[k]) continue;
    if (one.op == Op::t || (one.op >= Op::dwell && one.op <= Op::prescribed)) return false;
    if (is_leaf(one.op)) continue;
    tape.marks[one.a] = true;
    if (is_binary(one.op)) tape.marks[one.b] = true;
  }
  return true;
}

// u of the crossing between lo and hi, where the surface has the sign `side` and the other.
template <class T>
bool crossing_between(const Tape<T>& tape, int i, Real<T> lo, Real<T> hi, int side, T& out) {
  using R = Real<T>;
  for (int k = 0; k < 200; ++k) {  // halving to neighbours
    const R middle = (lo + hi) * 0.5;
    if (!(middle > lo && middle < hi)) break;
    (surface_at<R>(tape, i, tape.reals, middle) * side > 0 ? lo : hi) = middle;
  }
  out = T(hi);
  if constexpr (requires(T x) { x.d[0]; }) {
    Dual<4> u(hi);
    u.set_derivative(0, 1.0);
    const double slope = surface_at<Dual<4>>(tape, i, tape.slopes, u).derivative(0);
    const T at = surface_at<T>(tape, i, tape.numbers, out);
    if (slope == 0) return false;
    for (int k = 0; k < T::chunks; ++k) out.d[k] = -at.d[k] / slope;
  }
  return true;
}

// Every crossing over u > 0; `count` -1 where that cannot be told.
template <class T>
void find_crossings(Tape<T>& tape, int i, Crossings<T>& out) {
  out.searched = true;
  out.count = -1;
  if (!mark_surface(tape, i)) return;
  constexpr double forever = std::numeric_limits<double>::infinity();
  double at = 0, wide = 1;
  int side = 0, count = 0;
  for (int looks = 0; looks < most_range_looks; ++looks) {
    const auto keeps = [&](const Range& r) {
      const bool above = r.lo > 0 && side >= 0, below = r.hi < 0 && side <= 0;
      if (side == 0 && (above || below)) side = out.first = above ? 1 : -1;
      return above || below;
    };
    if (keeps(surface_over(tape, i, at, forever))) {
      out.count = count;
      return;
    }
    if (keeps(surface_over(tape, i, at, at + wide))) {
      at += wide;
      wide *= 2;
      continue;
    }
    wide *= 0.5;
    if (side == 0 || wide > 1e-3 * at) {
      if (wide < 1e-200) return;
      continue;
    }
    if (wide < 1e-15 * at) return;  // it only touches, or goes over where ranges do not see it
    if (!(surface_at<Real<T>>(tape, i, tape.reals, Real<T>(at + wide)) * side < 0)) continue;
    if (count == most_crossings || !crossing_between(tape, i, Real<T>(at), Real<T>(at + wide), side, out.at[count]))
      return;
    ++count;
    side = -side;
    at += wide;
  }
}

// The bounds of u between which the surface of node i keeps the side that it is on: those about the present u.
template <class T>
bool crossing_bounds(Tape<T>& tape, int i, Interval<T>& out) {
  if (tape.reads.direction == 0 || tape.reads.base_is_time) return false;
  Crossings<T>& c = *tape.node[i].crossings;
  if (!c.searched) find_crossings(tape, i, c);
  if (c.count < 0) return false;
  const Real<T> u = value(tape.reads.base[0]);
  Real<T> nearest(std::numeric_limits<double>::infinity());
  bool found = false;
  for (int k = 0, side = c.first; k <= c.count; ++k, side = -side) {
    if (side != tape.node[i].side) continue;
    Real<T> off(0.0);
    if (k > 0) off = largest(off, Real<T>(value(c.at[k - 1]) - u));
    if (k < c.count) off = largest(off, Real<T>(u - value(c.at[k])));
    if (!(off < nearest)) continue;
    nearest = off;
    found = true;
    out = {};
    out.has_lo = k > 0;
    out.has_hi = k < c.count;
    if (k > 0) out.lo = c.at[k - 1];
    if (k < c.count) out.hi = c.at[k];
  }
  return found;
}

}  // namespace stickslip::inline STICKSLIP_ISA
