// One operation of a formula on numbers.
#pragma once

#include "stickslip/bodies/tape.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Value of an operation on numbers, in any number type; min, max, abs and sign on the side given.
template <class T>
T apply(Op op, const T& a, const T& b, int side) {
  switch (op) {
    case Op::add: return a + b;
    case Op::subtract: return a - b;
    case Op::multiply: return a * b;
    case Op::divide: return a / b;
    case Op::power: return raised(a, b);
    case Op::negate: return -a;
    case Op::absolute: return side > 0 ? a : -a;
    case Op::sign: return T(side > 0 ? 1.0 : -1.0);
    case Op::maximum: return side > 0 ? a : b;
    case Op::minimum: return side > 0 ? b : a;
    case Op::exponential: return exponential(a);
    case Op::logarithm: return logarithm(a);
    case Op::square_root: return square_root(a);
    case Op::sine: return sine(a);
    case Op::cosine: return cosine(a);
    case Op::tangent: return tangent(a);
    case Op::tanh: return hyperbolic_tangent(a);
    case Op::asinh: return area_sine(a);
    default: return a;
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
