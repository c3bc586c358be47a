// Transitions that pile up: a run that would not end is ended.
#pragma once

#include "stickslip/isa.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// This many within `chatter_span` natural time units.
constexpr int chatter_window = 64;
constexpr double chatter_span = 1e-9;

template <class R>
struct Chatter {
  R recent[chatter_window];
  long seen = 0;  // its own count: only what it was shown is in `recent`

  // Takes the time of a change.
  bool sees(const R& t, const R& frequency) {
    R& slot = recent[seen % chatter_window];
    const bool dense = seen++ >= chatter_window && t - slot < chatter_span / frequency;
    slot = t;
    return dense;
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
