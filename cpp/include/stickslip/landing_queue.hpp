// The lines members wait in, one for each kind of piece: to be stepped, or to be landed together.
#pragma once

#include "stickslip/landing.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr int bin_count = 5;  // stick; either slip, curved or saturated
template <int W>
constexpr int pool_size = 6 * W;

inline int bin_of(const Mode& mode) {
  if (mode.contact == 0) return 0;
  return (mode.contact < 0 ? 1 : 3) + (mode.saturated ? 1 : 0);
}

template <int W>
struct Line {
  Member* member[bin_count][pool_size<W>];
  int length[bin_count] = {};

  void add(Member& m) {
    const int b = bin_of(m.mode);
    member[b][length[b]++] = &m;
  }
  Member* take(int b) { return member[b][--length[b]]; }
  int longest() const {  // -1 where nobody waits
    int best = 0;
    for (int b = 1; b < bin_count; ++b)
      if (length[b] > length[best]) best = b;
    return length[best] > 0 ? best : -1;
  }
};

// Takes lane i out of its batch as it is, to be landed later.
template <int W>
void defer(Batch<W>& b, int i, Line<W>& landing) {
  Member* m = b.member[i];
  m->on[watch_contact] = side_of(b, i);
  leave(b, i);
  landing.add(*m);
}

}  // namespace stickslip::inline STICKSLIP_ISA
