// What happens at a surface where a contact comes to rest or lets go, and which surfaces there are.
#pragma once

#include "stickslip/bodies/start.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr double rest_rounding = 1e-14;  // a compliant contact that moves less than this share of its motion stands

inline int release_direction(int id) { return id % 2 == 0 ? slips_minus : slips_plus; }

// Other contacts that stand on a limit at h and move beyond it: they let go together with the one that ends the piece.
template <class T>
void find_partners(const BodiesSystem<T>& sys, int id, int order, const Real<T>& h, signed char* partner) {
  for (int j = 0; j < sys.contacts; ++j) partner[j] = 0;
  if (id < 0 || id >= 2 * sys.contacts || sys.contact[id / 2].mode != sticks) return;
  for (int j = 0; j < sys.contacts; ++j) {
    if (sys.contact[j].mode != sticks || j == id / 2) continue;
    for (const int side : {0, 1}) {
      const T* margin = sys.margin + (2 * j + side) * series_size;
      if (value(evaluate(margin, order, h)) <= room_of(sys, j) * limit_rounding &&
          value(evaluate_slope(margin, order, h)) < 0)
        partner[j] = static_cast<signed char>(release_direction(2 * j + side));
    }
  }
}

template <class T>
void change_contact(BodiesSystem<T>& sys, BodiesState<T>& s, int id, const signed char* partner, Side* on) {
  Contact<T>& c = sys.contact[id / 2];
  if (c.mode == sticks) {
    let_go(c, release_direction(id));
    for (int j = 0; j < sys.contacts; ++j)
      if (partner[j] != 0) let_go(sys.contact[j], partner[j]);
    return settle(sys, s, on);
  }
  if (c.compliant[0]) {
    let_go(c, -c.mode);
  } else {
    come_to_rest(c, s.t);
  }
  settle(sys, s, on);
}

// The switching functions of the piece, contacts in their order, then the surfaces of formulas.
template <class T>
int list_watches(const BodiesSystem<T>& sys, Watch<T>* watch) {
  int watches = 0;
  const auto add = [&](const T* c, int id) -> Watch<T>& {
    Watch<T>& w = watch[watches++];
    w = Watch<T>{c, T(0.0), T(0.0), Real<T>(0.0), false, false, id};
    return w;
  };
  for (int j = 0; j < sys.contacts; ++j) {
    const Contact<T>& c = sys.contact[j];
    if (c.mode == sticks) {
      for (const int side : {0, 1}) {
        Watch<T>& w = add(sys.margin + (2 * j + side) * series_size, 2 * j + side);
        w.has_lo = true;
        w.rounding = Real<T>(room_of(sys, j) * limit_rounding);
      }
      continue;
    }
    Watch<T>& w = add(sys.u + j * series_size, 2 * j);
    w.lo = c.interval.lo;
    w.hi = c.interval.hi;
    w.has_lo = true;
    w.has_hi = c.interval.has_hi;
    if (!c.compliant[0]) continue;
    for (int i = 0; i < sys.n; ++i)  // at rest in balance it moves by rounding alone
      w.rounding = largest(
          w.rounding, Real<T>(magnitude(value(sys.D(j)[i] * sys.q[i * series_size])) * sys.frequency * rest_rounding));
  }
  const auto add_surfaces = [&](const Tape<T>& tape) {
    for (int i = 0; i < tape.surface_count; ++i) {
      const int node = tape.surfaces[i];
      Watch<T>& w = add(tape.surface_series + i * series_size, tape.first_id + node);
      (tape.node[node].side > 0 ? w.has_lo : w.has_hi) = true;
    }
  };
  for (int j = 0; j < sys.contacts; ++j) {
    const Contact<T>& c = sys.contact[j];
    for (const int side : {0, 1})
      if (c.mode == sticks || side == (c.mode > 0)) add_surfaces(c.tape[side]);
  }
  for (int e = 0; e < sys.pushes; ++e) add_surfaces(sys.push[e].tape);
  return watches;
}

// A step on, a trajectory stands on no surface any more, unless it has not moved away from it; not on the one it `met`.
template <class T>
void leave_surfaces(BodiesSystem<T>& sys, const Watch<T>* watch, int watches, int order, const Real<T>& h, int met,
                    Side* on, Side* next) {
  for (int id = 0; id < sys.ids; ++id) next[id] = Side::none;
  for (int w = 0; w < watches; ++w) {
    const int id = watch[w].id;
    if (id != met && still_on(watch[w], on[id], order, h)) next[id] = on[id];
  }
  for (int id = 0; id < sys.ids; ++id) on[id] = next[id];
  for (int j = 0; j < sys.contacts; ++j) sys.contact[j].leaving = sys.contact[j].leaving && on[2 * j] != Side::none;
}

}  // namespace stickslip::inline STICKSLIP_ISA
