// What a rig of bodies is made of: contacts, prescribed speeds, forces of effects.
#pragma once

#include "stickslip/bodies/run_tape.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr int slips_minus = -1, sticks = 0, slips_plus = 1;

template <class T>
struct Contact {
  Tape<T> tape[2];  // v < 0, v > 0
  int states = 0, first_state = 0, speed = -1;
  bool compliant[2] = {};
  signed char mode = 0;
  // of a mode in slip whose force is linear in u: T = level + slope (d . q' - V)
  bool linear = false;
  T level, slope;
  Interval<T> interval;  // of u, in which no linear surface changes its side
  bool leaving = false;  // it slips off from rest: u is 0 at the start of the piece
  bool tried = false;    // let go by the rule at this transition
  T since;               // time from which the dwell counts
};

template <class T>
struct Push {  // a force of an effect
  Tape<T> tape;
  int states = 0, first_state = 0;
  bool moves = false;   // it has a direction
  bool steady = false;  // constant at present
};

template <class T>
struct Rail {  // a prescribed speed
  Tape<T>* piece;
  int now = 0;
  bool steady = true, filled = false;  // constant at present; its series stands
  bool linear = true;                  // linear in t at present
  double before = 0, size = 0;         // what it was just before a corner; the largest that it has been at one
};

}  // namespace stickslip::inline STICKSLIP_ISA
