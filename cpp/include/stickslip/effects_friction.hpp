// Friction of a contact with effects, slipping or stuck, and its static limits, coefficient by coefficient.
#pragma once

#include "stickslip/at.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Bits of the effects for which has<E>() holds.
template <class Has>
consteval std::uint32_t bits_of_those(const Has& has) {
  std::uint32_t bits = 0;
  const auto one = [&]<class E> { bits |= has.template operator()<E>() ? bit_of<E> : 0; };
  [&]<class... E>(TypeList<E...>) { (one.template operator()<E>(), ...); }(Effects{});
  return bits;
}
constexpr std::uint32_t moves_belt = bits_of_those([]<class E> { return requires { &E::template belt<double>; }; });
constexpr std::uint32_t yields_belt =
    bits_of_those([]<class E> { return requires { &E::template belt_yield<double>; }; });
// Bristles in the contact: it has no rigid stick.
constexpr std::uint32_t yields = bits_of_those([]<class E> { return requires { &E::template contact<double>; }; });

// What multiplies friction, kinetic and static. Null if nothing does.
template <class T>
const T* friction_factor(const System<T>& sys, const Mode& mode, const State<T>& begin, Piece<T>& piece, int k) {
  EffectSeries<T>& fx = piece.fx;
  const T* last = nullptr;
  each_acting(sys, mode, begin, piece, [&](const auto& at) __attribute__((always_inline)) {
    using E = typename std::decay_t<decltype(at)>::Effect;
    if constexpr (HasShare<E>) {
      if constexpr (requires { &E::template shares<T>; })
        if (!E::shares(at)) return;
      T* share = fx.share[share_of<E>];
      T* out = fx.factor[share_of<E>];
      share[k] = E::share(at, k);
      out[k] = last == nullptr ? share[k] + constant(T(1.0), k) : product(last, share, k) + last[k];
      last = out;
    }
  });
  return last;
}

// Friction T of a slipping contact, coefficient k.
template <class T>
T slip_friction(const System<T>& sys, const Mode& mode, const State<T>& begin, Piece<T>& piece, int k) {
  EffectSeries<T>& fx = piece.fx;
  const Branch<T>& b = branch_of(sys, mode.contact);
  const double dir = mode.contact;
  fx.u[k] = fx.v[k] * dir;
  each_acting(sys, mode, begin, piece, [&](const auto& at) __attribute__((always_inline)) {
    using E = typename std::decay_t<decltype(at)>::Effect;
    if constexpr (requires { &E::template argument<T>; }) fx.u[k] = E::argument(at, k);
  });
  T r = constant(mode.saturated ? b.saturated : b.c0, k);
  if (!mode.saturated) {
    r = r + b.c1 * fx.u[k];
    with_curve(b, [&]<class L> { r = r + L::next(b.own, fx.u, own_series<L>(fx.law), k); });
  }
  each_acting(sys, mode, begin, piece, [&](const auto& at) __attribute__((always_inline)) {
    using E = typename std::decay_t<decltype(at)>::Effect;
    if constexpr (requires { &E::template magnitude<T>; }) r = r + E::magnitude(at, k);
  });
  fx.magnitude[k] = r;
  const T* factor = friction_factor(sys, mode, begin, piece, k);
  fx.kinetic[k] = factor == nullptr ? r : product(fx.magnitude, factor, k);
  T friction = fx.kinetic[k] * dir;
  each_acting(sys, mode, begin, piece, [&](const auto& at) __attribute__((always_inline)) {
    using E = typename std::decay_t<decltype(at)>::Effect;
    if constexpr (requires { &E::template contact<T>; }) friction = E::contact(at, k);
  });
  return friction;
}

// Static limits of both directions, coefficient k.
template <class T>
void limits_next(const System<T>& sys, const Mode& mode, const State<T>& begin, Piece<T>& piece, int k) {
  EffectSeries<T>& fx = piece.fx;
  T extra(0.0);
  each_acting(sys, mode, begin, piece, [&](const auto& at) __attribute__((always_inline)) {
    using E = typename std::decay_t<decltype(at)>::Effect;
    if constexpr (requires { &E::template limit<T>; }) extra = extra + E::limit(at, k);
  });
  const T* factor = friction_factor(sys, mode, begin, piece, k);
  fx.at_minus[k] = constant(sys.minus.static_limit, k) + extra;
  fx.at_plus[k] = constant(sys.plus.static_limit, k) + extra;
  fx.limit_minus[k] = factor == nullptr ? fx.at_minus[k] : product(factor, fx.at_minus, k);
  fx.limit_plus[k] = factor == nullptr ? fx.at_plus[k] : product(factor, fx.at_plus, k);
}

// Friction of a stuck contact: T = -q, q = (Q + M rate)/(1 + M yield) on a belt with V' = rate + yield T.
template <class T>
T stick_friction(const System<T>& sys, const Mode& mode, const State<T>& begin, Piece<T>& piece, const T& force,
                 int k) {
  const Series<T>& s = piece.s;
  T q = demand(sys.rig, s.x1[k], s.x2[k], s.y1[k], s.y2[k]) - force, yield(0.0);
  each_acting(sys, mode, begin, piece, [&](const auto& at) __attribute__((always_inline)) {
    using E = typename std::decay_t<decltype(at)>::Effect;
    if constexpr (requires { &E::template belt_rate<T>; }) q = q + sys.rig.a1 * E::belt_rate(at, k);
    if constexpr (requires { &E::template belt_yield<T>; }) yield = yield + sys.rig.a1 * E::belt_yield(at);
  });
  return acts(sys, yields_belt) ? T(-(q / (T(1.0) + yield))) : -q;
}

}  // namespace stickslip::inline STICKSLIP_ISA
