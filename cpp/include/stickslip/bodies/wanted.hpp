// Which nodes a result is made of.
#pragma once

#include "stickslip/bodies/classify.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Where a min, max or abs passes an operand on, what it reads is that operand.
template <class T>
int source(const Tape<T>& tape, int i) {
  for (;;) {
    const Node& one = tape.at(i);
    const auto side = tape.node[i].side;
    if (one.op == Op::maximum || one.op == Op::minimum) {
      i = (one.op == Op::maximum) == (side > 0) ? one.a : one.b;
    } else if (one.op == Op::absolute && side > 0) {
      i = one.a;
    } else {
      return i;
    }
  }
}

// Marks what the value of node i is made of; with `surfaces`, also what may change a side on the way.
template <class T>
void want(Tape<T>& tape, int root, bool surfaces) {
  tape.wanted[root] = true;
  for (int i = root; i >= 0; --i) {
    if (!tape.wanted[i] || is_leaf(tape.at(i).op)) continue;
    const Node& one = tape.at(i);
    if (surfaces || source(tape, i) == i) {
      if (!surfaces && tape.node[i].form == Form::constant) continue;
      tape.wanted[one.a] = true;
      if (is_binary(one.op)) tape.wanted[one.b] = true;
    } else {
      tape.wanted[source(tape, i)] = true;
    }
  }
}

template <class T>
void clear_wanted(Tape<T>& tape) {
  for (int i = 0; i < tape.formulas->count; ++i) tape.wanted[i] = false;
}

}  // namespace stickslip::inline STICKSLIP_ISA
