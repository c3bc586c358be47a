// From a tape to its instructions in one mode.
#pragma once

#include "stickslip/bodies/crossings.hpp"
#include "stickslip/bodies/emit.hpp"

namespace stickslip::inline STICKSLIP_ISA {

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

// The bounds on u at which the surface of node i changes its sign, where it is linear in u or of u alone.
template <class T>
bool surface_bounds(Tape<T>& tape, int i, Interval<T>& out) {
  T bound(0.0);
  bool above = false;
  if (!linear_surface(tape, i, bound, above)) return crossing_bounds(tape, i, out);
  out = {};
  (above ? out.has_lo : out.has_hi) = true;
  (above ? out.lo : out.hi) = bound;
  return true;
}

// Drops the instructions that nothing reads, of sums that were taken in whole by others.
template <class T>
void drop_unread(Tape<T>& tape, const int* roots, int root_count, int watched) {
  const auto is_read = [](const Instruction<T>* list, int from, int count, const T* c) {
    for (int i = from; i < count; ++i)
      if (list[i].a == c || list[i].b == c) return true;
    return false;
  };
  const auto is_root = [&](const T* c) {
    for (int r = 0; r < root_count; ++r)
      if (tape.node[source(tape, roots[r])].c == c) return true;
    return watched >= 0 && tape.node[source(tape, watched)].c == c;
  };
  for (int i = tape.inners - 1; i >= 0; --i) {
    const T* c = tape.inner[i].c;
    if (is_root(c) || is_read(tape.inner, i + 1, tape.inners, c) || is_read(tape.outer, 0, tape.outers, c)) continue;
    for (int k = i + 1; k < tape.inners; ++k) tape.inner[k - 1] = tape.inner[k];
    --tape.inners;
  }
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
  Interval<T> bounds;
  bool any = watched >= 0;
  for (int i = 0; i < n; ++i)
    if (tape.wanted[i] && is_piecewise(tape.at(i).op) && tape.node[i].watched && !surface_bounds(tape, i, bounds)) {
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
  drop_unread(tape, roots, root_count, watched);
}

}  // namespace stickslip::inline STICKSLIP_ISA
