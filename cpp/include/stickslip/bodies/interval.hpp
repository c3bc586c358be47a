// Intervals of u, and what a formula may be worth over one.
#pragma once

#include "stickslip/isa.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Bounds on u within which every surface that hangs on u alone keeps its side; what lies at 0 or below is none.
template <class T>
struct Interval {
  T lo{0.0}, hi{0.0};
  bool has_lo = false, has_hi = false;
};

struct Range {  // of numbers: all that a formula may be worth
  double lo, hi;
};

constexpr int most_crossings = 4;
// Where the surface of a node, of u alone, changes its sign over u > 0; count -1 where that is not known.
template <class T>
struct Crossings {
  bool searched = false;
  int count = -1, first = 0;  // first: its sign before all of them
  T at[most_crossings];
};

}  // namespace stickslip::inline STICKSLIP_ISA
