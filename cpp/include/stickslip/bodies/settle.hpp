// Which contacts stick: at the start, where one comes to rest, where one lets go, where a prescribed speed changes.
//
// The rule. All that are at rest are held first, by the forces of one linear system. Whichever of these is beyond its
// static limit lets go: the one with the largest excess beside its limits, those of equal excess together; with its kinetic
// force put in, the others are asked again. A contact on its limit, to rounding, sticks. A contact that reaches its limit
// lets go, and with it every contact that stands on its own limit at that time and moves beyond it.
#pragma once

#include "stickslip/bodies/look.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr double equal_excess = 1e-9;
constexpr double rest_share = 1e-12;  // of the speeds that v is the difference of

template <class T>
void let_go(Contact<T>& c, int direction) {
  c.mode = static_cast<signed char>(direction);
  c.leaving = true;
  forget_sides(tape_of(c));
}
template <class T>
void come_to_rest(Contact<T>& c, const T& t) {
  c.mode = sticks;
  c.leaving = false;
  c.since = t;
  forget_sides(c.tape[0]);
  forget_sides(c.tape[1]);
}

// Room between the limits of a stuck contact, which forces are compared with.
template <class T>
double room_of(const BodiesSystem<T>& sys, int j) {
  return static_cast<double>(value(sys.margin[2 * j * series_size]) + value(sys.margin[(2 * j + 1) * series_size]));
}

// Applies the rule. `on` is set for what stands on a limit.
template <class T>
void settle(BodiesSystem<T>& sys, BodiesState<T>& s, Side* on) {
  for (int round = 0; round <= sys.contacts; ++round) {
    look(sys, s);
    double worst = 0;
    const auto excess = [&](int j, int side) {
      const double beyond = -static_cast<double>(value(sys.margin[(2 * j + side) * series_size]));
      const double room = room_of(sys, j);
      return beyond > limit_rounding * room ? beyond / (room > 0 ? room : 1.0) : 0.0;
    };
    for (int h = 0; h < sys.stuck_count; ++h)
      for (const int side : {0, 1}) worst = std::max(worst, excess(sys.stuck[h], side));
    if (worst == 0) break;
    for (int h = 0; h < sys.stuck_count; ++h)
      for (const int side : {0, 1})
        if (const double e = excess(sys.stuck[h], side); e > 0 && e >= worst * (1 - equal_excess)) {
          let_go(sys.contact[sys.stuck[h]], side == 0 ? slips_minus : slips_plus);
          break;
        }
  }
  for (int j = 0; j < sys.contacts; ++j) {
    const Contact<T>& c = sys.contact[j];
    if (c.mode != sticks) {
      if (c.leaving) on[2 * j] = Side::lower;
      on[2 * j + 1] = Side::none;
      continue;
    }
    for (const int side : {0, 1}) {
      const double margin = static_cast<double>(value(sys.margin[(2 * j + side) * series_size]));
      on[2 * j + side] = margin <= limit_rounding * room_of(sys, j) ? Side::lower : Side::none;
    }
  }
}

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

// Modes by the speeds alone (2 in `given`), or as given; then the rule. `jumped`: speeds that are not what they were.
template <class T>
void set_bodies_modes(BodiesSystem<T>& sys, BodiesState<T>& s, const signed char* given, bool at_start, Side* on) {
  set_first(sys, s);
  link_speeds(sys);
  expand_speeds(sys, 1);
  for (int j = 0; j < sys.contacts; ++j) {
    Contact<T>& c = sys.contact[j];
    const double v = static_cast<double>(value(relative_speed(sys, s, j)));
    double size = c.speed < 0 ? 0.0 : std::abs(static_cast<double>(value(sys.V[c.speed * series_size])));
    for (int i = 0; i < sys.n; ++i) size += std::abs(static_cast<double>(value(sys.D(j)[i]) * value(s.z[sys.n + i])));
    const bool rest = std::abs(v) <= rest_share * size;
    const int asked = at_start && given[j] != 2 ? given[j] : (rest ? sticks : (v < 0 ? slips_minus : slips_plus));
    if (!at_start && (asked == c.mode || (rest && c.leaving))) continue;
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
