// The modes at the start, and where a prescribed speed goes over to another piece.
#pragma once

#include "stickslip/bodies/settle.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// A compliant contact at rest goes the way it is pushed.
template <class T>
void set_compliant(BodiesSystem<T>& sys, BodiesState<T>& s) {
  for (int j = 0; j < sys.contacts; ++j) {
    Contact<T>& c = sys.contact[j];
    if (!c.compliant[0] || c.mode != sticks) continue;
    let_go(c, slips_plus);
    look(sys, s);
    double push = 0;
    for (int i = 0; i < sys.n; ++i) push += static_cast<double>(value(sys.D(j)[i]) * value(sys.v[i * series_size + 1]));
    if (c.speed >= 0) push -= static_cast<double>(value(sys.V[c.speed * series_size + 1]));
    if (push < 0) let_go(c, slips_minus);
  }
}

// Modes by the speeds alone (2 in `given`), or as given; then the rule. Where it goes on, a contact whose prescribed speed
// does not jump is in the mode that it was in, whatever rounding makes of its speed.
template <class T>
void set_bodies_modes(BodiesSystem<T>& sys, BodiesState<T>& s, const signed char* given, bool at_start, Side* on) {
  set_first(sys, s);
  link_speeds(sys);
  expand_speeds(sys, 1);
  for (int i = 0; i < sys.speeds; ++i)
    sys.rail[i].size = std::max(sys.rail[i].size, std::abs(static_cast<double>(value(sys.V[i * series_size]))));
  for (int j = 0; j < sys.contacts; ++j) {
    Contact<T>& c = sys.contact[j];
    const double V = c.speed < 0 ? 0.0 : static_cast<double>(value(sys.V[c.speed * series_size]));
    const double before = c.speed < 0 || at_start ? V : sys.rail[c.speed].before;
    double size = std::abs(V) + std::abs(before);
    if (!at_start && (c.speed < 0 || std::abs(V - before) <= rest_share * (size + sys.rail[c.speed].size))) continue;
    const double v = static_cast<double>(value(relative_speed(sys, s, j)));
    for (int i = 0; i < sys.n; ++i) size += std::abs(static_cast<double>(value(sys.D(j)[i]) * value(s.z[sys.n + i])));
    const bool rest = std::abs(v) <= rest_share * size;
    const int asked = at_start && given[j] != 2 ? given[j] : (rest ? sticks : (v < 0 ? slips_minus : slips_plus));
    if (!at_start && (asked == c.mode || (rest && c.leaving))) {
      if (c.mode != sticks) forget_sides_of_slip(tape_of(c));
      if (!rest) {
        on[2 * j] = on[2 * j + 1] = Side::none;
        c.leaving = false;
      }
      continue;
    }
    on[2 * j] = on[2 * j + 1] = Side::none;
    const T since = c.since;
    if (asked == sticks && !c.compliant[0]) {
      come_to_rest(c, s.t);
      if (at_start) c.since = since;
    } else if (asked == sticks) {
      c.mode = sticks;
    } else {
      let_go(c, asked);
      c.leaving = rest;
    }
  }
  set_compliant(sys, s);
  settle(sys, s, on);
}

}  // namespace stickslip::inline STICKSLIP_ISA
