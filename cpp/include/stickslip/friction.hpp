// The friction laws, each a file of friction/: what a branch of any of them is at a speed, and where it saturates.
#pragma once

#include "stickslip/branch.hpp"
#include "stickslip/parameters.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Is the branch b one with a curve, and of the law L?
template <class L, class T>
bool has_curve(const Branch<T>& b) {
  if constexpr (requires { &L::template curve<T>; }) return b.curve == index_in<L>(Laws{});
  return false;
}

// f with the law whose curve the branch has; nothing on a straight one.
template <class T, class F>
[[gnu::always_inline]] inline void with_curve(const Branch<T>& b, const F& f) {
  const auto one = [&]<class L> {
    if constexpr (requires { &L::template curve<T>; })
      if (has_curve<L>(b)) f.template operator()<L>();
  };
  [&]<class... L>(TypeList<L...>) { (one.template operator()<L>(), ...); }(Laws{});
}

template <class T>
T curve(const Branch<T>& b, const T& u) {
  T r = b.c0 + b.c1 * u;
  with_curve(b, [&]<class L> { r = r + L::curve(b.own, u); });
  return r;
}

template <class T>
T curve_slope(const Branch<T>& b, const T& u) {
  T r = b.c1;
  with_curve(b, [&]<class L> { r = r + L::slope(b.own, u); });
  return r;
}

// Kinetic magnitude at u >= 0, saturation included.
template <class T>
T magnitude(const Branch<T>& b, const T& u) {
  if (b.has_kink && value(u) >= value(b.kink)) return b.saturated;
  return curve(b, u);
}

// Direction -1: slip with v_w < 0; +1: slip with v_w > 0. A curve that starts at or below its floor is all floor.
template <class T>
Branch<T> branch(int law, const Parameters<T>& p, int direction) {
  Branch<T> b{};
  const auto one = [&]<class L> {
    if (law != index_in<L>(Laws{})) return;
    b = L::branch(Numbers<L, T>{p.p + first_slot<L>}, direction);
    if (b.curve == own_curve) b.curve = law;
  };
  [&]<class... L>(TypeList<L...>) { (one.template operator()<L>(), ...); }(Laws{});
  if (!b.has_kink || value(b.kink) > 0) return b;
  Branch<T> floor{};
  floor.static_limit = b.static_limit;
  floor.c0 = b.saturated;
  return floor;
}

}  // namespace stickslip::inline STICKSLIP_ISA
