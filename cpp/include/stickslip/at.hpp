// What the terms of an effect see: its numbers, its side, the series of the piece.
#pragma once

#include "stickslip/piece.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
bool acts(const System<T>& sys, std::uint32_t effects) {
  return (sys.structure.effects & effects) != 0;
}

// A speed this small beside the motion's is rounding: surfaces of x2 and y2 may coincide at 0.
constexpr double speed_rounding = 1e-15;

// Append a watch on `sign` times a series; returns it for its bounds.
template <class T>
Watch<T>& watch_series(Piece<T>& piece, int id, const T* c, double sign, int order) {
  T* out = piece.switching[piece.watches];
  for (int k = 0; k <= order; ++k) out[k] = c[k] * sign;
  Watch<T>& w = piece.watch[piece.watches++];
  w.id = id;
  w.has_lo = w.has_hi = false;
  w.rounding = Real<T>(0.0);
  w.c = out;
  return w;
}

template <class E, class T>
struct At {
  using Effect = E;
  const System<T>& sys;
  const Mode& mode;
  const State<T>& begin;  // of the piece
  Piece<T>& piece;

  Numbers<E, T> numbers() const { return {sys.p.p + first_slot<E>}; }
  const T& operator[](Key<E> key) const { return numbers()[key]; }
  auto& own() const { return own_series<E>(piece.fx.own); }
  int side() const { return mode.side[surface_of<E>]; }
  int contact() const { return mode.contact; }

  const T& t() const { return begin.t; }
  const T* x1() const { return piece.s.x1; }
  const T* x2() const { return piece.s.x2; }
  const T* y1() const { return piece.s.y1; }
  const T* y2() const { return piece.s.y2; }
  const T* v() const { return piece.fx.v; }
  const T* u() const { return piece.fx.u; }                // the speed that kinetic friction depends on
  const T* friction() const { return piece.fx.friction; }  // T
  const T* kinetic() const { return piece.fx.kinetic; }    // the magnitude of sliding friction
  T* hidden() const { return state_series(piece, state_of<E>); }
  const T& hidden_start() const { return begin.z[state_of<E>]; }

  // What all effects of the sensor add to x1.
  T reading(int k) const {
    T sum = x1()[k];
    const auto one = [&]<class Other> {
      if constexpr (requires { &Other::template reading<T>; })
        sum = sum + Other::reading(At<Other, T>{sys, mode, begin, piece}, k);
    };
    [&]<class... Other>(TypeList<Other...>) { (one.template operator()<Other>(), ...); }(Effects{});
    return sum;
  }

  Real<T> motion_scale() const { return stickslip::motion_scale(sys, piece.s); }
  Real<T> speed_rounding() const { return Real<T>(motion_scale() * stickslip::speed_rounding); }
  // Lists a surface of `sign` times a series; its bounds are to be given.
  Watch<T>& watch(const T* c, double sign, int order) const {
    return watch_series(piece, effect_watch<E>, c, sign, order);
  }
};

// f(at) for every effect that acts.
template <class T, class F>
[[gnu::always_inline]] inline void each_acting(const System<T>& sys, const Mode& mode, const State<T>& begin,
                                               Piece<T>& piece, const F& f) {
  const auto one = [&]<class E>() __attribute__((always_inline)) {
    if (acts(sys, bit_of<E>)) f(At<E, T>{sys, mode, begin, piece});
  };
  [&]<class... E>(TypeList<E...>) __attribute__((always_inline)) { (one.template operator()<E>(), ...); }(Effects{});
}

}  // namespace stickslip::inline STICKSLIP_ISA
