// From a tape to its instructions in one mode.
#pragma once

#include "stickslip/bodies/emit.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Bounds on u within which every linear surface keeps its side; what lies at 0 or below is none.
template <class T>
struct Interval {
  T lo{0.0}, hi{0.0};
  bool has_lo = false, has_hi = false;
};

// u at which the linear surface of node i changes its sign.
template <class T>
bool linear_surface(const Tape<T>& tape, int i, T& bound, bool& above) {
  const Node& one = tape.at(i);
  const NodeFacts<T>& a = tape.node[one.a];
  const bool two = is_binary(one.op);
  T level(0.0), slope(0.0);
  for (const int sign : {1, -1}) {
    if (sign < 0 && !two) continue;
    const NodeFacts<T>& f = sign > 0 ? a : tape.node[one.b];
    if (f.form == Form::curved) return false;
    level = level + f.level * static_cast<double>(sign);
    if (f.form == Form::affine) slope = slope + f.slope * static_cast<double>(sign);
  }
  if (value(slope) == 0) {
    bound = T(0.0);  // never: the sides are equal everywhere or nowhere
    return true;
  }
  bound = -level / slope;
  above = (value(slope) > 0) == (tape.node[i].side > 0);  // the side holds for u above the bound
  return true;
}

// Classifies all nodes and lists the instructions: `roots` drive the motion, `watched` (or -1) is only looked at.
template <class T>
void link(Tape<T>& tape, const int* roots, int root_count, int watched) {
  const int n = tape.formulas->count;
  for (int i = 0; i < n; ++i) classify(tape, i);
  clear_wanted(tape);
  for (int r = 0; r < root_count; ++r) want(tape, roots[r], false);
  Emitter<T> inner{tape, tape.inner};
  inner.wanted_nodes();
  tape.inners = inner.count;
  clear_wanted(tape);
  for (int r = 0; r < root_count; ++r) want(tape, roots[r], true);
  if (watched >= 0) want(tape, watched, true);
  Emitter<T> outer{tape, tape.outer};
  tape.surface_count = 0;
  tape.jumps = false;
  T bound(0.0);
  bool above = false;
  bool any = watched >= 0;
  for (int i = 0; i < n; ++i)
    if (tape.wanted[i] && is_piecewise(tape.at(i).op) && tape.node[i].watched &&
        !linear_surface(tape, i, bound, above)) {
      tape.surfaces[tape.surface_count++] = i;
      tape.jumps = tape.jumps || tape.at(i).op == Op::sign;
      any = true;
    }
  if (any) outer.wanted_nodes();
  for (int k = 0; k < tape.surface_count; ++k) {
    const Node& one = tape.at(tape.surfaces[k]);
    Instruction<T>& sum = outer.list[outer.count++];
    sum = {Code::combine, -1, nullptr, nullptr, T(1.0), T(1.0), T(0.0), tape.surface_series + k * series_size, nullptr};
    outer.add_term(sum, one.a, T(1.0));
    if (is_binary(one.op)) outer.add_term(sum, one.b, T(-1.0));
  }
  tape.outers = outer.count;
}

}  // namespace stickslip::inline STICKSLIP_ISA
