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

  // Takes the time of change n = 1, 2, ...
  bool sees(long n, const R& t, const R& frequency) {
    R& slot = recent[n % chatter_window];
    const bool dense = n > chatter_window && t - slot < chatter_span / frequency;
    slot = t;
    return dense;
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
