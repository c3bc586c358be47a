// What an effect sees where a run starts, at a surface and when the contact changes.
#pragma once

#include "stickslip/at.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class E, class T>
struct Turn {
  using Effect = E;
  const System<T>& sys;
  State<T>& s;
  Mode& mode;
  Side* on;  // which bound of each surface the trajectory stands on and is leaving
  Piece<T>& piece;

  At<E, T> at() const { return {sys, mode, s, piece}; }
  Numbers<E, T> numbers() const { return {sys.p.p + first_slot<E>}; }
  const T& operator[](Key<E> key) const { return numbers()[key]; }
  int& side() const { return mode.side[surface_of<E>]; }
  Side& stands() const { return on[effect_watch<E>]; }
  T& hidden() const { return s.z[state_of<E>]; }

  static int sign_of(Side through) { return through == Side::lower ? -1 : 1; }
  // It stands on the lower bound of its surface.
  void stands_inside() const { stands() = Side::lower; }
  // The next side that way.
  void step(Side through) const {
    side() += sign_of(through);
    stands() = opposite(through);
  }
};

// f(turn) for every effect that acts.
template <class T, class F>
void each_turn(const System<T>& sys, State<T>& s, Mode& mode, Side* on, Piece<T>& piece, const F& f) {
  const auto one = [&]<class E> {
    if (acts(sys, bit_of<E>)) f(Turn<E, T>{sys, s, mode, on, piece});
  };
  [&]<class... E>(TypeList<E...>) { (one.template operator()<E>(), ...); }(Effects{});
}

}  // namespace stickslip::inline STICKSLIP_ISA
