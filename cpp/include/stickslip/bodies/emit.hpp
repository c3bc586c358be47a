// The instructions of a linked tape: nodes that are neither constant nor linear, in order, and what feeds them.
#pragma once

#include "stickslip/bodies/wanted.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr double zero_share = 1e-13;

template <class T>
struct Emitter {
  Tape<T>& tape;
  Instruction<T>* list;
  int count = 0;

  NodeFacts<T>& facts(int i) { return tape.node[source(tape, i)]; }
  Instruction<T>& put(Code code, NodeFacts<T>& f, int i) {
    Instruction<T>& out = list[count++];
    out = {code, i, nullptr, nullptr, T(1.0), T(1.0), T(0.0), f.own, f.aux};
    f.c = f.own;
    f.placed = true;
    f.made = &out;
    return out;
  }
  static bool is_scaled(const Instruction<T>& in) {
    return in.code == Code::combine && in.a != nullptr && in.b == nullptr;
  }
  // Adds factor * node to a sum of at most two series and a constant.
  void add_term(Instruction<T>& sum, int i, const T& factor) {
    const NodeFacts<T>& f = facts(i);
    if (f.form != Form::curved) sum.level = sum.level + factor * f.level;
    if (f.form == Form::constant) return;
    const bool affine = f.form == Form::affine;
    const T* series = affine ? tape.reads.base : f.c;
    T by = affine ? factor * f.slope : factor;
    if (const Instruction<T>* made = affine ? nullptr : f.made; made != nullptr && is_scaled(*made)) {
      sum.level = sum.level + factor * made->level;  // level + x a: taken in whole
      by = factor * made->x;
      series = made->a;
    }
    if (sum.a == nullptr) {
      sum.a = series;
      sum.x = by;
    } else {
      sum.b = series;
      sum.y = by;
    }
  }
  // The series of a node that is not constant.
  const T* series(int i) {
    const int from = source(tape, i);
    NodeFacts<T>& f = tape.node[from];
    if (!f.placed) {  // affine: nothing asked for its series so far
      Instruction<T>& sum = put(Code::combine, f, from);
      sum.a = tape.reads.base;
      sum.x = f.slope;
      sum.level = f.level;
    }
    return f.c;
  }
  void argument(Instruction<T>& out, int i) {  // of an exponential: level + x a
    out.x = T(1.0);
    out.a = nullptr;
    add_term(out, i, T(1.0));
  }
  void combine(int i, int first, const T& x, int second, const T& y) {
    Instruction<T>& sum = put(Code::combine, tape.node[i], i);
    add_term(sum, first, x);
    if (second >= 0) add_term(sum, second, y);
  }
  // Below what share of its largest value the base of a power is 0: a tape whose base is time reads what lands on 0.
  T rounding() const { return T(tape.reads.base == tape.reads.time ? zero_share : 0.0); }
  void power(int i, const Node& one) {
    const NodeFacts<T>&a = facts(one.a), &b = facts(one.b);
    NodeFacts<T>& f = tape.node[i];
    if (b.form == Form::constant) {
      const double p = static_cast<double>(value(b.level));
      if (is_plain(b.level) && (p == 0 || p == 1)) {
        Instruction<T>& sum = put(Code::combine, f, i);
        if (p == 0) {
          sum.level = T(1.0);
        } else {
          add_term(sum, one.a, T(1.0));
        }
        return;
      }
      const T* base = series(one.a);
      const bool whole = is_plain(b.level) && p == std::floor(p) && p >= 2 && p <= largest_whole_power &&
                         tape.at(one.b).op == Op::parameter;
      Instruction<T>& out = put(whole ? Code::whole_power : Code::power, f, i);
      out.a = base;
      out.x = b.level;
      if (!whole) out.y = rounding();
    } else if (a.form == Form::constant) {
      const T rate = logarithm(a.level);
      Instruction<T>& out = put(Code::exponential, f, i);
      add_term(out, one.b, rate);
    } else {
      const T *base = series(one.a), *exponent = series(one.b);
      Instruction<T>& out = put(Code::open_power, f, i);
      out.a = base;
      out.b = exponent;
    }
  }
  void node(int i) {
    NodeFacts<T>& f = tape.node[i];
    if (f.placed || f.form != Form::curved || source(tape, i) != i) return;
    const Node& one = tape.at(i);
    const T unit(1.0);
    const auto is_constant = [&](int k) { return facts(k).form == Form::constant; };
    switch (one.op) {
      case Op::add: return combine(i, one.a, unit, one.b, unit);
      case Op::subtract: return combine(i, one.a, unit, one.b, -unit);
      case Op::negate:
      case Op::absolute: return combine(i, one.a, -unit, -1, unit);
      case Op::multiply: {
        if (is_constant(one.a)) return combine(i, one.b, facts(one.a).level, -1, unit);
        if (is_constant(one.b)) return combine(i, one.a, facts(one.b).level, -1, unit);
        const T *a = series(one.a), *b = series(one.b);
        Instruction<T>& out = put(Code::multiply, f, i);
        out.a = a;
        out.b = b;
        return;
      }
      case Op::divide: {
        if (is_constant(one.b)) return combine(i, one.a, unit / facts(one.b).level, -1, unit);
        const bool over = is_constant(one.a);
        const T *a = over ? nullptr : series(one.a), *b = series(one.b);
        Instruction<T>& out = put(over ? Code::over : Code::divide, f, i);
        out.a = a;
        out.b = b;
        if (over) out.level = facts(one.a).level;
        return;
      }
      case Op::power: return power(i, one);
      case Op::exponential: return argument(put(Code::exponential, f, i), one.a);
      default: break;
    }
    const T* a = series(one.a);
    constexpr Code codes[] = {Code::logarithm, Code::power, Code::sine, Code::cosine,
                              Code::tangent,   Code::tanh,  Code::asinh};
    Instruction<T>& out = put(codes[static_cast<int>(one.op) - static_cast<int>(Op::logarithm)], f, i);
    out.a = a;
    if (one.op != Op::square_root) return;
    out.x = T(0.5);
    out.y = rounding();
  }
  void wanted_nodes() {
    for (int i = 0; i < tape.formulas->count; ++i)
      if (tape.wanted[i]) node(i);
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
