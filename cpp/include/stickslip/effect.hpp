// What a file of effects/ is made of. Each defines one struct, named after the file, that holds all the core knows of an
// effect: its numbers, its own state and series, its terms, its surface. Whatever is not there, the effect has not.
//
//   parameters            names of its numbers, as declared; at["tau"] is one
//   hidden                the state that it adds
//   Series<T>             coefficients of its own, at.own()
// Terms, coefficient k of each (At is what they see; docs/effects.md has the equations):
//   belt                  on the belt's speed V, with belt_rate, its part of V' but for friction's, and belt_yield, V' by
//                         friction
//   prepare               what its other terms need, ahead of them
//   block, angle_body     forces
//   share                 friction is multiplied by 1 + it, static limits included; `shares` says whether, if not always
//   argument              the speed that kinetic friction depends on instead of u
//   magnitude             on R(u)
//   limit                 on both static limits
//   contact               friction in the place of sliding friction
//   pivot                 force on the angle body in the place of `net`, that of all the rest
//   rate                  of its hidden state; `state` says what that is at the end of a step, where it is not its series
//   reading               on what the sensor of x1 sees
// Surface:
//   watch                 lists it
//   start                 where a run starts; start_by_force where that depends on all the other terms
//   cross                 what happens there, if not a step of its side
//   halts, changes        the block comes to rest; its contact has changed
//   slips                 the block slips: the first instant
//   smooth                nothing jumps there: a crossing that hardly moves needs no derivative
// Steps:
//   decides               its series that must be resolved beside the motion
//   shorten, settle       limits of a step, and what is done once it is known
//   variant               lanes that differ in it do not meet
#pragma once

#include "stickslip/branch.hpp"
#include "stickslip/lanewise.hpp"
#include "stickslip/names.hpp"
#include "stickslip/tolerance.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class E, class T>
struct At;  // at.hpp
template <class E, class T>
struct Turn;  // turn.hpp

// A state that an effect adds; `place` among them all is that in a start given by numbers.
struct Hidden {
  std::string_view name;
  int place;
};

// (a a a)_k with the square kept.
template <class T>
T cube_next(const T* a, T* square, int k) {
  square[k] = product(a, a, k);
  return product(square, a, k);
}

// sin and cos of w t + phi, times an amplitude.
template <class T>
struct Oscillation {
  T sin[series_size], cos[series_size];
  const T& next(const T& amplitude, const T& w, const T& phi, const T& t0, int k) {
    if (k == 0) {
      sin[0] = amplitude * sine(w * t0 + phi);
      cos[0] = amplitude * cosine(w * t0 + phi);
    } else {
      sin[k] = w * cos[k - 1] * inverse<T>(k);
      cos[k] = -(w * sin[k - 1]) * inverse<T>(k);
    }
    return sin[k];
  }
};

template <class T>
double plain(const T& x) {
  return static_cast<double>(value(x));
}

}  // namespace stickslip::inline STICKSLIP_ISA
