// A piece of a trajectory with effects: the whole vector field as series.
//
// Equations as in docs/effects.md. The block feels -T; B and A are the extra forces on block and angle body, M =
// alpha1, Q = M kx x1 + e1 (x2 + y2) + s y1 - B:
//   slip   M x2' = -(Q + T)                 T = sgn(v) (factor) R(u), or what the contact's bristles hold
//   stick  x2 = V(t), T = -q                belt   V = v_b + what effects add
#pragma once

#include "stickslip/effects_friction.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// The belt's own speed V and v_w, coefficient k; on a stuck block x2 too.
template <class T>
void belt_next(const System<T>& sys, const Mode& mode, const State<T>& begin, Piece<T>& piece, int k) {
  T belt = constant(sys.rig.v_b, k);
  each_acting(sys, mode, begin, piece, [&](const auto& at) __attribute__((always_inline)) {
    using E = typename std::decay_t<decltype(at)>::Effect;
    if constexpr (requires { &E::template belt<T>; }) belt = belt + E::belt(at, k);
  });
  piece.fx.belt[k] = belt;
}

// The state at the start of the piece, as the first coefficients.
template <class T>
void begin_series(const State<T>& begin, Piece<T>& piece, int from = 0) {
  const auto one = [&]<class E> {
    if constexpr (requires { &E::template rate<T>; }) state_series(piece, state_of<E>)[0] = begin.z[state_of<E>];
  };
  [&]<class... E>(TypeList<E...>) { (one.template operator()<E>(), ...); }(Effects{});
  for (int i = from; i < visible_count; ++i) state_series(piece, i)[0] = begin.z[i];
}

// All series of the piece, `order` of them.
template <class T>
void expand_effects(const System<T>& sys, const Mode& mode, const State<T>& begin, int order, Piece<T>& piece) {
  const Rig<T>& r = sys.rig;
  Series<T>& s = piece.s;
  EffectSeries<T>& fx = piece.fx;
  begin_series(begin, piece, visible_count);
  for (int k = 0; k <= order; ++k) {
    const Real<T> over = inverse<T>(k + 1);
    belt_next(sys, mode, begin, piece, k);
    if (mode.contact == 0) s.x2[k] = fx.belt[k];
    fx.v[k] = s.x2[k] - fx.belt[k];
    T force(0.0), leg(0.0);
    each_acting(sys, mode, begin, piece, [&](const auto& at) __attribute__((always_inline)) {
      using E = typename std::decay_t<decltype(at)>::Effect;
      if constexpr (requires { &E::template prepare<T>; }) E::prepare(at, k);
      if constexpr (requires { &E::template block<T>; }) force = force + E::block(at, k);
      if constexpr (requires { &E::template angle_body<T>; }) leg = leg + E::angle_body(at, k);
    });
    if (mode.contact == 0) {
      fx.friction[k] = stick_friction(sys, mode, begin, piece, force, k);
      limits_next(sys, mode, begin, piece, k);
    } else {
      fx.friction[k] = slip_friction(sys, mode, begin, piece, k);
      s.x2[k + 1] =
          -(r.kx * s.x1[k] + (bracket(r, s.x2[k], s.y1[k], s.y2[k]) + fx.friction[k] - force) * r.over_a1) * over;
    }
    s.x1[k + 1] = s.x2[k] * over;
    s.y1[k + 1] = s.y2[k] * over;
    T drive = -(r.b3 * s.y1[k] + r.e12 * s.y2[k] + s.x1[k] + r.e1 * s.x2[k]) + leg;
    each_acting(sys, mode, begin, piece, [&](const auto& at) __attribute__((always_inline)) {
      using E = typename std::decay_t<decltype(at)>::Effect;
      if constexpr (requires { &E::template rate<T>; }) at.hidden()[k + 1] = E::rate(at, k) * over;
      if constexpr (requires { &E::template pivot<T>; }) drive = E::pivot(at, drive, k);
    });
    s.y2[k + 1] = r.two ? drive * r.over_a2 * over : T(0.0);
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
