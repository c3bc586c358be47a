// Of every node of a tape, whether it is constant, linear or curved in one mode, and on which side it stands.
#pragma once

#include "stickslip/bodies/apply.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Form, value and side of a node whose operands are known.
template <class T>
void classify_leaf(Tape<T>& tape, int i) {
  const Node& one = tape.at(i);
  NodeFacts<T>& f = tape.node[i];
  const Reads<T>& r = tape.reads;
  const auto series = [&](const T* c) {
    f.form = Form::curved;
    f.c = const_cast<T*>(c);
    f.placed = true;
    f.now = value(c[0]);
  };
  const auto linear = [&](double slope) {
    f.form = Form::affine;
    f.level = T(0.0);
    f.slope = T(slope);
    f.now = value(r.base[0]) * slope;
  };
  f.form = Form::constant;
  f.level = T(0.0);
  switch (one.op) {
    case Op::parameter: f.level = r.parameters[one.a]; break;
    case Op::u:
      if (r.direction != 0) linear(1.0);
      break;
    case Op::v:
      if (r.direction != 0) linear(r.direction);
      break;
    case Op::t:
      if (r.base_is_time) {
        linear(1.0);
      } else {
        series(r.time);
      }
      break;
    case Op::dwell: series(r.dwell); break;
    case Op::coordinate: series(r.coordinates + one.a * series_size); break;
    case Op::velocity: series(r.velocities + one.a * series_size); break;
    case Op::distance: series(r.distances + one.a * series_size); break;
    case Op::prescribed: series(r.speeds + one.a * series_size); break;
    default: series(r.states[one.a]); break;
  }
  if (f.form == Form::constant) f.now = value(f.level);
}

// The side of an abs, sign, min or max by its surface; on the surface, by where it goes as u grows.
template <class T>
void choose_side(Tape<T>& tape, int i) {
  const Node& one = tape.at(i);
  NodeFacts<T>& f = tape.node[i];
  const NodeFacts<T>& a = tape.node[one.a];
  const bool two = is_binary(one.op);
  const Form other = two ? tape.node[one.b].form : Form::constant;
  const Real<T> gap = two ? a.now - tape.node[one.b].now : a.now;
  f.watched = a.form != Form::constant || other != Form::constant;
  if (f.watched && f.side != 0) return;
  Real<T> slope(0.0);
  if (a.form == Form::affine) slope += value(a.slope);
  if (other == Form::affine) slope -= value(tape.node[one.b].slope);
  f.side = gap > 0 || (gap == 0 && slope >= 0) ? 1 : -1;
}

template <class T>
void classify(Tape<T>& tape, int i) {
  const Node& one = tape.at(i);
  NodeFacts<T>& f = tape.node[i];
  f.c = f.own;
  f.placed = f.watched = false;
  f.made = nullptr;
  f.weight = Real<T>(0.0);
  if (is_leaf(one.op)) return classify_leaf(tape, i);
  const NodeFacts<T>& a = tape.node[one.a];
  const NodeFacts<T>& b = is_binary(one.op) ? tape.node[one.b] : a;
  if (is_piecewise(one.op)) choose_side(tape, i);
  f.now = apply(one.op, a.now, b.now, f.side);
  f.form = a.form > b.form ? a.form : b.form;
  const bool flat = f.form == Form::constant;
  if (one.op == Op::sign || flat) {
    f.form = Form::constant;
    f.level = flat ? apply(one.op, a.level, b.level, f.side) : T(f.side > 0 ? 1.0 : -1.0);
    return;
  }
  if (one.op == Op::minimum || one.op == Op::maximum || (one.op == Op::absolute && f.side > 0)) {
    const bool first = one.op == Op::absolute || (one.op == Op::maximum) == (f.side > 0);
    const NodeFacts<T>& kept = first ? a : b;
    f.form = kept.form;
    f.level = kept.level;
    f.slope = kept.slope;
    f.c = kept.c;
    return;
  }
  if (f.form != Form::affine) return;
  const T zero(0.0), a_slope = a.form == Form::affine ? a.slope : zero,
                     b_slope = b.form == Form::affine ? b.slope : zero;
  switch (one.op) {
    case Op::add:
      f.level = a.level + b.level;
      f.slope = a_slope + b_slope;
      return;
    case Op::subtract:
      f.level = a.level - b.level;
      f.slope = a_slope - b_slope;
      return;
    case Op::negate:
    case Op::absolute:
      f.level = -a.level;
      f.slope = -a_slope;
      return;
    case Op::multiply:
      if (a.form == Form::affine && b.form == Form::affine) break;
      f.level = a.level * b.level;
      f.slope = a.form == Form::affine ? a_slope * b.level : a.level * b_slope;
      return;
    case Op::divide:
      if (b.form != Form::constant) break;
      f.level = a.level / b.level;
      f.slope = a_slope / b.level;
      return;
    case Op::power:
      if (b.form != Form::constant || value(b.level) != 1 || !is_plain(b.level)) break;
      f.level = a.level;
      f.slope = a_slope;
      return;
    default: break;
  }
  f.form = Form::curved;
}

}  // namespace stickslip::inline STICKSLIP_ISA
