// The forces that effects add, and the surfaces of formulas.
#pragma once

#include "stickslip/bodies/system.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Links the tape of a force; of one without a direction only the rates of its states.
template <class T>
void link_push(BodiesSystem<T>& sys, int e) {
  Push<T>& p = sys.push[e];
  const BranchTape& formulas = *p.tape.formulas;
  int roots[1 + most_law_states];
  int count = 0;
  if (p.moves) roots[count++] = formulas.force;
  for (int i = 0; i < p.states; ++i) roots[count++] = formulas.rates[i];
  link(p.tape, roots, count, -1);
  p.steady = !p.moves || p.tape.node[source(p.tape, formulas.force)].form == Form::constant;
}

// Coefficient k of the force and the rates of a push.
template <class T>
void push_next(BodiesSystem<T>& sys, int e, int k, bool rates) {
  Push<T>& p = sys.push[e];
  run(p.tape.inner, p.tape.inners, k);
  if (p.moves) sys.force[(sys.contacts + e) * series_size + k] = coefficient(p.tape, p.tape.formulas->force, k);
  if (!rates) return;
  for (int i = 0; i < p.states; ++i)
    sys.z[(p.first_state + i) * series_size + k + 1] =
        coefficient(p.tape, p.tape.formulas->rates[i], k) * inverse<T>(k + 1);
}

// To what order the surfaces of a formula are expanded. Where the force goes over continuously an error in the time of it
// counts by its square.
template <class T>
int watched_order(const BodiesSystem<T>& sys, const Tape<T>& tape, int order) {
  return tape.jumps || order < sys.surface_order ? order : sys.surface_order;
}
template <class T>
int watched_order(const BodiesSystem<T>& sys, int j, const Tape<T>& tape, int order) {
  return sys.contact[j].mode == sticks ? order : watched_order(sys, tape, order);
}

template <class T>
void expand_surfaces(Tape<T>& tape, int top, int order) {
  for (int k = 0; k <= top; ++k) run(tape.outer, tape.outers, k);
  for (int i = 0; i < tape.surface_count; ++i)
    for (int k = top + 1; k <= order; ++k) tape.surface_series[i * series_size + k] = T(0.0);
}

}  // namespace stickslip::inline STICKSLIP_ISA
