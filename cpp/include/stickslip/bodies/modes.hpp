// What the modes of all contacts make of the equations: forces that are linear in the speeds join the matrices, stuck
// contacts are held by the forces that solve D_s q'' = V_s':
//
//   G T_s = D_s M^-1 F - V_s',  G = D_s M^-1 D_s'
// (Leine and van de Wouw 2008, chapter 5).
#pragma once

#include "stickslip/bodies/build.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
Tape<T>& tape_of(Contact<T>& c) {  // in stick the states of a law move as on its branch v < 0
  return c.tape[c.mode > 0 ? 1 : 0];
}

// Links the tapes of a contact for its mode.
template <class T>
void link_contact(BodiesSystem<T>& sys, int j) {
  Contact<T>& c = sys.contact[j];
  const LawTape& law = sys.b->laws[j];
  if (c.mode == sticks) {
    for (int s = 0; s < 2; ++s) {
      c.tape[s].reads.direction = 0;
      link(c.tape[s], law.branch[s].rates, s == 0 ? c.states : 0, law.branch[s].limit);
    }
    c.linear = true;
    c.level = c.slope = T(0.0);
    c.interval = {};
    return;
  }
  Tape<T>& tape = tape_of(c);
  const BranchTape& branch = *tape.formulas;
  tape.reads.direction = c.mode;
  int roots[1 + most_law_states];
  roots[0] = branch.force;
  for (int i = 0; i < c.states; ++i) roots[1 + i] = branch.rates[i];
  link(tape, roots, 1 + c.states, -1);
  const NodeFacts<T>& f = tape.node[source(tape, branch.force)];
  c.linear = f.form != Form::curved;
  const double sign = c.compliant[c.mode > 0] ? 1.0 : c.mode;  // of what the tape gives in T
  c.level = c.linear ? f.level * sign : T(0.0);
  c.slope = f.form == Form::affine ? f.slope * (sign * c.mode) : T(0.0);
  c.interval = {};
  c.interval.has_lo = true;
  for (int i = 0; i < branch.count; ++i) {
    if (!tape.wanted[i] || !is_piecewise(tape.at(i).op) || !tape.node[i].watched) continue;
    Interval<T> one, &in = c.interval;
    if (!surface_bounds(tape, i, one)) continue;
    if (one.has_lo && value(one.lo) > value(in.lo)) in.lo = one.lo;
    if (one.has_hi && value(one.hi) > 0 && (!in.has_hi || value(one.hi) < value(in.hi))) {
      in.hi = one.hi;
      in.has_hi = true;
    }
  }
}

template <class T>
void link_speeds(BodiesSystem<T>& sys) {
  for (int s = 0; s < sys.speeds; ++s) {
    Rail<T>& one = sys.rail[s];
    Tape<T>& tape = one.piece[one.now];
    const int root = tape.formulas->force;
    link(tape, &root, 1, -1);
    const NodeFacts<T>& f = tape.node[source(tape, root)];
    one.steady = f.form == Form::constant;
    one.linear = f.form != Form::curved;
    one.filled = false;
  }
}

template <class T>
Real<T> block_bound(BodiesSystem<T>& sys, int first) {
  const int n = sys.n;
  for (int i = 0; i < n * n; ++i) sys.room[i] = sys.projected[i / n * sys.columns + first + i % n];
  return eigenvalue_bound(sys.room, sys.weight, n);
}

// The matrices of the present modes, from linked contacts.
template <class T>
void hold_stuck(BodiesSystem<T>& sys) {
  const int n = sys.n, columns = sys.columns, m = sys.contacts;
  for (int i = 0; i < n * columns; ++i) sys.projected[i] = sys.free[i];
  sys.stuck_count = 0;
  for (int j = 0; j < m; ++j) {
    const Contact<T>& c = sys.contact[j];
    if (c.mode == sticks) {
      sys.stuck[sys.stuck_count++] = j;
      continue;
    }
    if (!c.linear) continue;
    for (int i = 0; i < n; ++i) {
      const T by = -sys.reach[j * n + i];
      T* row = sys.projected + i * columns;
      const T sloped = by * c.slope;
      for (int k = 0; k < n; ++k) add_product(row[n + k], sloped, sys.D(j)[k]);
      add_product(row[2 * n], by, c.level);
      if (c.speed >= 0) row[2 * n + 1 + sys.speeds + c.speed] = row[2 * n + 1 + sys.speeds + c.speed] - sloped;
    }
  }
  const int held = sys.stuck_count;
  if (held == 0) return;
  for (int a = 0; a < held; ++a)
    for (int c = 0; c < held; ++c)
      sys.compliance[a * held + c] = dot(sys.D(sys.stuck[a]), sys.reach + sys.stuck[c] * n, n);
  invert(sys.compliance, sys.stiff, held);
  for (int a = 0; a < held; ++a) multiply(sys.D(sys.stuck[a]), sys.projected, 1, n, columns, sys.room + a * columns);
  multiply(sys.stiff, sys.room, held, held, columns, sys.held);
  for (int i = 0; i < n; ++i)
    for (int a = 0; a < held; ++a) {
      const T by = sys.reach[sys.stuck[a] * n + i];
      for (int k = 0; k < columns; ++k) add_product(sys.projected[i * columns + k], -by, sys.held[a * columns + k]);
      T s(0.0);
      for (int c = 0; c < held; ++c) add_product(s, sys.reach[sys.stuck[c] * n + i], sys.stiff[c * held + a]);
      sys.yields[i * held + a] = s;
    }
  if (held == n)  // nothing is left to move but with what it sticks to
    for (int i = 0; i < n * columns; ++i) sys.projected[i] = T(0.0);
}

template <class T>
void hold(BodiesSystem<T>& sys) {
  hold_stuck(sys);
  sys.rate = square_root(block_bound(sys, 0)) + block_bound(sys, sys.n);
}

}  // namespace stickslip::inline STICKSLIP_ISA
