// One operation of a formula on ranges of numbers: all that its value can be.
#pragma once

#include "stickslip/bodies/apply.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr Range anything{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};

// The smallest range that holds four numbers; what is not a number may be anything.
inline Range hull(double a, double b, double c, double d) {
  if (!(a + b + c + d == a + b + c + d) && (a != a || b != b || c != c || d != d)) return anything;
  return {smallest(smallest(a, b), smallest(c, d)), largest(largest(a, b), largest(c, d))};
}

// f rises: a function of one number, or of its range's ends.
template <class F>
Range rising(const Range& a, const F& f) {
  const double lo = f(a.lo), hi = f(a.hi);
  return lo <= hi ? Range{lo, hi} : anything;
}

inline Range range_of_power(const Range& a, const Range& b) {
  const auto at = [](double x, double p) { return std::pow(x, p); };
  if (a.lo >= 0) return hull(at(a.lo, b.lo), at(a.lo, b.hi), at(a.hi, b.lo), at(a.hi, b.hi));
  if (b.lo != b.hi || b.lo != std::floor(b.lo) || b.lo < 0) return anything;
  const double lo = at(a.lo, b.lo), hi = at(a.hi, b.lo);
  if (std::fmod(b.lo, 2.0) != 0) return lo <= hi ? Range{lo, hi} : anything;
  return {a.hi >= 0 ? 0.0 : hi, largest(lo, hi)};
}

inline Range range_of(Op op, const Range& a, const Range& b) {
  const double wide = (a.hi - a.lo) * 0.5, middle = a.lo + wide;
  switch (op) {
    case Op::add: return {a.lo + b.lo, a.hi + b.hi};
    case Op::subtract: return {a.lo - b.hi, a.hi - b.lo};
    case Op::negate: return {-a.hi, -a.lo};
    case Op::multiply: return hull(a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi);
    case Op::divide:
      return b.lo <= 0 && b.hi >= 0 ? anything : hull(a.lo / b.lo, a.lo / b.hi, a.hi / b.lo, a.hi / b.hi);
    case Op::power: return range_of_power(a, b);
    case Op::absolute: return a.lo >= 0 ? a : (a.hi <= 0 ? Range{-a.hi, -a.lo} : Range{0.0, largest(-a.lo, a.hi)});
    case Op::sign: return {a.lo > 0 ? 1.0 : -1.0, a.hi > 0 ? 1.0 : -1.0};
    case Op::maximum: return {largest(a.lo, b.lo), largest(a.hi, b.hi)};
    case Op::minimum: return {smallest(a.lo, b.lo), smallest(a.hi, b.hi)};
    case Op::exponential: return rising(a, [](double x) { return std::exp(x); });
    case Op::logarithm: return a.lo < 0 ? anything : rising(a, [](double x) { return std::log(x); });
    case Op::square_root: return a.lo < 0 ? anything : rising(a, [](double x) { return std::sqrt(x); });
    case Op::tanh: return rising(a, [](double x) { return std::tanh(x); });
    case Op::asinh: return rising(a, [](double x) { return std::asinh(x); });
    case Op::sine:
    case Op::cosine: {
      const double at = op == Op::sine ? std::sin(middle) : std::cos(middle);
      return wide < 2 ? Range{at - wide, at + wide} : Range{-1.0, 1.0};
    }
    default: return anything;
  }
}

// The surface of node i (a - b, or a), of its nodes that are marked; `leaf` gives those without operands.
template <class X, class T, class Leaf>
X gap_at(const Tape<T>& tape, int i, X* room, const Leaf& leaf) {
  for (int k = 0; k < i; ++k) {
    if (!tape.marks[k]) continue;
    const Node& one = tape.at(k);
    if (is_leaf(one.op)) {
      room[k] = leaf(one);
      continue;
    }
    const X &a = room[one.a], &b = is_binary(one.op) ? room[one.b] : a;
    if constexpr (std::is_same_v<X, Range>) {
      room[k] = range_of(one.op, a, b);
    } else {
      const bool above = one.op == Op::maximum || one.op == Op::minimum ? value(a) > value(b) : value(a) > 0;
      room[k] = apply(one.op, a, b, above ? 1 : -1);
    }
  }
  const Node& one = tape.at(i);
  const X& a = room[one.a];
  if (!is_binary(one.op)) return a;
  if constexpr (std::is_same_v<X, Range>) {
    return range_of(Op::subtract, a, room[one.b]);
  } else {
    return a - room[one.b];
  }
}

// The surface of node i at u, in the number type of the computation or (of numbers alone) another.
template <class X, class T>
X surface_at(const Tape<T>& tape, int i, X* room, const X& u) {
  return gap_at(tape, i, room, [&](const Node& one) -> X {
    if (one.op == Op::u) return u;
    if (one.op == Op::v) return u * tape.reads.direction;
    if constexpr (std::is_same_v<X, T>) {
      return tape.reads.parameters[one.a];
    } else {
      return X(value(tape.reads.parameters[one.a]));
    }
  });
}
// All that it may be for u in [lo, hi].
template <class T>
Range surface_over(const Tape<T>& tape, int i, double lo, double hi) {
  return gap_at(tape, i, tape.ranges, [&](const Node& one) {
    if (one.op == Op::u || (one.op == Op::v && tape.reads.direction > 0)) return Range{lo, hi};
    if (one.op == Op::v) return Range{-hi, -lo};
    const auto x = static_cast<double>(value(tape.reads.parameters[one.a]));
    return Range{x, x};
  });
}

}  // namespace stickslip::inline STICKSLIP_ISA
