// Formulas that go over to other pieces: which surfaces are met together, and on which side each is left.
#pragma once

#include "stickslip/bodies/changes.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr double same_bound = 1e-12;  // bounds of u nearer than this, relatively, are one: knots that two pieces share
constexpr int departures = 5;         // orders at which a departure is looked for
constexpr double on_surface = 1e-12;  // of what a surface moves by: rounding at most
constexpr double departing = 1e-9;    // the same: more than rounding

constexpr double just_beyond = 1e-10;  // a bound of u, where the sides beyond it are looked at

constexpr double together = 1e-14;  // of the motion of a surface over a piece: what is as near to zero is zero

// Chooses the sides beyond a bound of u anew, of every surface of u alone that lies at it.
template <class T>
void turn_pieces(Contact<T>& c, double bound, bool upwards) {
  Tape<T>& tape = tape_of(c);
  const Real<T> beyond(bound * (upwards ? 1 + just_beyond : 1 - just_beyond));
  for (int i = 0; i < tape.formulas->count; ++i) {
    Interval<T> in;
    if (!is_piecewise(tape.at(i).op) || !tape.node[i].watched || !surface_bounds(tape, i, in)) continue;
    const auto is_there = [&](bool has, const T& at) {
      return has && std::abs(static_cast<double>(value(at)) - bound) <= same_bound * std::abs(bound);
    };
    if (!is_there(in.has_lo, in.lo) && !is_there(in.has_hi, in.hi)) continue;
    int side = -tape.node[i].side;
    if (mark_surface(tape, i)) {  // a max that only touches there, as its operand has a kink, keeps its side
      const Real<T> gap = surface_at<Real<T>>(tape, i, tape.reals, beyond);
      if (gap != 0) side = gap > 0 ? 1 : -1;
    }
    tape.node[i].side = static_cast<signed char>(side);
  }
}

// Is it a bound at which a formula goes over to another piece, and not one at which a contact changes its mode?
template <class T>
bool is_kink(const BodiesSystem<T>& sys, const Watch<T>& w, Side side) {
  if (w.id >= 2 * sys.contacts) return true;
  return sys.contact[w.id / 2].mode != sticks && !(side == Side::lower && value(w.lo) == 0);
}

// By how much S may move over a span: sum over k >= 1 of |c_k| span^k.
template <class T>
Real<T> moves_by(const T* c, int order, const Real<T>& span) {
  Real<T> sum(0.0);
  for (int k = order; k >= 1; --k) sum = (sum + magnitude(value(c[k]))) * span;
  return sum;
}

// Is S of a piece, which ends at t, on a bound at its end, to rounding, and on its way out?
template <class T>
bool met_too(const Watch<T>& w, Side side, int order, const Real<T>& h, const Real<T>& t) {
  using R = Real<T>;
  const R slope = value(evaluate_slope(w.c, order, h));
  if (side == Side::lower ? !(slope < 0) : !(slope > 0)) return false;
  const R scale = magnitude(value(w.c[0])) + moves_by(w.c, order, h);
  const R off = magnitude(value(evaluate(w.c, order, h)) - value(side == Side::lower ? w.lo : w.hi));
  const R instant = magnitude(t) * (4 * std::numeric_limits<R>::epsilon());
  return off <= largest(R(scale * together), R(magnitude(slope) * instant));
}

// Is S beyond a bound at the start of a piece by more than rounding over the time `span`?
template <class T>
bool far_beyond(const Watch<T>& w, const T& bound, const Real<T>& span) {
  return magnitude(value(w.c[0]) - value(bound)) > moves_by(w.c, departures, span) * departing;
}

// Calls f(tape, node) for the node of a tape whose surface has this id.
template <class T, class F>
void at_node(BodiesSystem<T>& sys, int id, F&& f) {
  const auto look_in = [&](Tape<T>& tape) {
    const int node = id - tape.first_id;
    if (node >= 0 && node < tape.formulas->count) f(tape, node);
  };
  for (int j = 0; j < sys.contacts; ++j)
    for (Tape<T>& tape : sys.contact[j].tape) look_in(tape);
  for (int e = 0; e < sys.pushes; ++e) look_in(sys.push[e].tape);
}

// What the surface of a node is of: 0 of none.
template <class T>
std::uint64_t surface_key(BodiesSystem<T>& sys, int id) {
  std::uint64_t out = 0;
  at_node(sys, id, [&](const Tape<T>& tape, int i) {
    const Node& one = tape.at(i);
    out = tape.key[one.a] ^ (is_binary(one.op) ? tape.key[one.b] * 3 : 0);
  });
  return out;
}

// Formulas go over to other pieces. What is met at the same time, such as abs(q) and sign(q), in whatever tape, is passed
// together: the others would be passed after no time, which would take the trajectory off the first.
template <class T>
void change_pieces(BodiesSystem<T>& sys, BodiesState<T>& s, const Exit<T>& exit, const Watch<T>* watch, int watches,
                   int order, Side* on) {
  const std::uint64_t key = surface_key(sys, watch[exit.watch].id);
  for (int w = 0; w < watches; ++w)
    for (const Side side : {Side::lower, Side::upper}) {
      const int id = watch[w].id;
      if (!(side == Side::lower ? watch[w].has_lo : watch[w].has_hi) || !is_kink(sys, watch[w], side)) continue;
      const bool same =
          w == exit.watch ? side == exit.side : key != 0 && side == exit.side && surface_key(sys, id) == key;
      if (!same && (w == exit.watch || !met_too(watch[w], side, order, exit.t, value(s.t)))) continue;
      if (id < 2 * sys.contacts) {
        const double bound = static_cast<double>(value(side == Side::lower ? watch[w].lo : watch[w].hi));
        turn_pieces(sys.contact[id / 2], bound, side == Side::upper);
      } else {
        at_node(sys, id,
                [](Tape<T>& tape, int i) { tape.node[i].side = static_cast<signed char>(-tape.node[i].side); });
      }
      on[id] = opposite(side);
    }
  look(sys, s);
}

// Surfaces of formulas that a trajectory stands on where modes change, as abs(v) does where a body lets go: each side is
// the one that it leaves to, by its first coefficient that is more than rounding over the time `span`.
template <class T>
void face_surfaces(BodiesSystem<T>& sys, BodiesState<T>& s, Watch<T>* watch, const Real<T>& span, Side* on) {
  using R = Real<T>;
  expand_bodies(sys, departures);
  bool any = false;
  for (int w = 0, watches = list_watches(sys, watch); w < watches; ++w) {
    if (watch[w].id < 2 * sys.contacts) continue;
    const T* c = watch[w].c;
    const R scale = moves_by(c, departures, span);
    if (magnitude(value(c[0])) > scale * on_surface) continue;
    R power = span;
    int k = 1;
    for (; k <= departures && !(magnitude(value(c[k])) * power > scale * departing); ++k) power *= span;
    if (k > departures) continue;
    const bool above = value(c[k]) > 0;
    on[watch[w].id] = above ? Side::lower : Side::upper;
    if (above == watch[w].has_lo) continue;
    any = true;
    at_node(sys, watch[w].id,
            [&](Tape<T>& tape, int i) { tape.node[i].side = static_cast<signed char>(above ? 1 : -1); });
  }
  if (any) look(sys, s);
}

}  // namespace stickslip::inline STICKSLIP_ISA
