// Which contacts stick: at the start, where one comes to rest, where one lets go, where a prescribed speed changes.
//
// The rule. All that are at rest are held first, by the forces of one linear system. Whichever of these is beyond its
// static limit lets go: the one with the largest excess beside its limits, those of equal excess together; with its kinetic
// force put in, the others are asked again. One that let go and is pushed the other way by others that let go after it is
// held again. A contact on its limit, to rounding, sticks. A contact that reaches its limit
// lets go, and with it every contact that stands on its own limit at that time and moves beyond it.
#pragma once

#include "stickslip/bodies/look.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr double equal_excess = 1e-9;
constexpr double rest_share = 1e-12;  // of the speeds that v is the difference of

template <class T>
void let_go(Contact<T>& c, int direction) {
  const bool watched = c.mode == sticks;  // both tapes are, in stick
  c.mode = static_cast<signed char>(direction);
  c.leaving = true;
  watched ? forget_sides_of_slip(tape_of(c)) : forget_sides(tape_of(c));
}
template <class T>
void come_to_rest(Contact<T>& c, const T& t) {
  Tape<T>&was = tape_of(c), &other = c.tape[c.mode > 0 ? 0 : 1];
  forget_sides(other);
  if (c.mode == sticks) {
    forget_sides(was);
  } else {  // where both directions have the same surface, it stands on the side that it stood on
    forget_sides_of_slip(was);
    for (int i = 0; i < other.formulas->count && i < was.formulas->count; ++i)
      if (other.key[i] == was.key[i]) other.node[i].side = was.node[i].side;
  }
  c.mode = sticks;
  c.leaving = false;
  c.since = t;
}

// Room between the limits of a stuck contact, which forces are compared with.
template <class T>
double room_of(const BodiesSystem<T>& sys, int j) {
  return static_cast<double>(value(sys.margin[2 * j * series_size]) + value(sys.margin[(2 * j + 1) * series_size]));
}

// Lets go whichever of the stuck is most beyond its limit; false if none is.
template <class T>
bool release_worst(BodiesSystem<T>& sys) {
  double worst = 0;
  const auto excess = [&](int j, int side) {
    const double beyond = -static_cast<double>(value(sys.margin[(2 * j + side) * series_size]));
    const double room = room_of(sys, j);
    return beyond > limit_rounding * room ? beyond / (room > 0 ? room : 1.0) : 0.0;
  };
  for (int h = 0; h < sys.stuck_count; ++h)
    for (const int side : {0, 1}) worst = std::max(worst, excess(sys.stuck[h], side));
  if (worst == 0) return false;
  for (int h = 0; h < sys.stuck_count; ++h)
    for (const int side : {0, 1})
      if (const double e = excess(sys.stuck[h], side); e > 0 && e >= worst * (1 - equal_excess)) {
        let_go(sys.contact[sys.stuck[h]], side == 0 ? slips_minus : slips_plus);
        sys.contact[sys.stuck[h]].tried = true;
        break;
      }
  return true;
}

// Holds again what let go by the rule and is then pushed the other way, by others that let go after it.
template <class T>
bool take_back(BodiesSystem<T>& sys) {
  bool any = false;
  for (int j = 0; j < sys.contacts; ++j) {
    Contact<T>& c = sys.contact[j];
    if (c.mode == sticks || !c.tried) continue;
    double push = 0, size = 0;
    const auto add = [&](const T& a) {
      push += static_cast<double>(value(a));
      size += std::abs(static_cast<double>(value(a)));
    };
    for (int i = 0; i < sys.n; ++i) add(sys.D(j)[i] * sys.v[i * series_size + 1]);
    if (c.speed >= 0) add(-sys.V[c.speed * series_size + 1]);
    if (push * c.mode >= -limit_rounding * size) continue;
    c.mode = sticks;
    c.leaving = c.tried = false;
    any = true;
  }
  return any;
}

// Applies the rule. `on` is set for what stands on a limit.
template <class T>
void settle(BodiesSystem<T>& sys, BodiesState<T>& s, Side* on) {
  for (int j = 0; j < sys.contacts; ++j) sys.contact[j].tried = false;
  for (int round = 0, most = 4 * sys.contacts; round <= most; ++round) {
    look(sys, s);
    if (!release_worst(sys) && (round >= most - sys.contacts || !take_back(sys))) break;
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

}  // namespace stickslip::inline STICKSLIP_ISA
