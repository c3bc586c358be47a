// One more coefficient of every series of a linked tape.
#pragma once

#include "stickslip/bodies/recurrences.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
[[gnu::always_inline]] inline T next(const Instruction<T>& in, int k) {
  T *slope = in.aux, *other = in.aux + series_size;
  switch (in.code) {
    case Code::combine: {
      T s = k == 0 ? in.level : T(0.0);
      if (in.a != nullptr) add_product(s, in.x, in.a[k]);
      if (in.b != nullptr) add_product(s, in.y, in.b[k]);
      return s;
    }
    case Code::multiply: return product(in.a, in.b, k);
    case Code::divide:
    case Code::over: {
      if (k == 0) in.aux[0] = T(1.0) / in.b[0];
      const T top = in.a != nullptr ? in.a[k] : (k == 0 ? in.level : T(0.0));
      return quotient_next(top, in.b, in.c, in.aux[0], k);
    }
    case Code::power: return power_next(in, k);
    case Code::whole_power: return whole_power_next(in, k);
    case Code::open_power: {
      T over = T(1.0) / in.a[0];
      T* turned = in.aux + 2 * series_size;
      other[k] = logarithm_next(in.a, other, over, k);
      turned[k] = product(other, in.b, k);
      return exponential_of(slope, in.c, turned[k], k);
    }
    case Code::exponential: {
      T argument = in.x * in.a[k];
      if (k == 0) argument = argument + in.level;
      return exponential_of(slope, in.c, argument, k);
    }
    case Code::logarithm: return logarithm_next(in.a, in.c, in.aux[0], k);
    case Code::sine:
    case Code::cosine: {
      const bool is_sine = in.code == Code::sine;
      if (k == 0) {
        other[0] = is_sine ? cosine(in.a[0]) : sine(in.a[0]);
        return is_sine ? sine(in.a[0]) : cosine(in.a[0]);
      }
      const T a = slope_product(slope, in.a, other, k), b = rotation_next(slope, in.c, k);
      other[k] = is_sine ? -b : b;
      return is_sine ? a : -a;
    }
    case Code::tangent:
    case Code::tanh: {
      const double sign = in.code == Code::tangent ? 1.0 : -1.0;
      T c = k > 0 ? slope_product(slope, in.a, other, k)
                  : (in.code == Code::tangent ? tangent(in.a[0]) : hyperbolic_tangent(in.a[0]));
      in.c[k] = c;
      other[k] = product(in.c, in.c, k) * sign;
      if (k == 0) other[0] = other[0] + 1.0;
      return c;
    }
    default: return asinh_next(in, k);
  }
}

template <class T>
void run(const Instruction<T>* list, int count, int k) {
  for (int i = 0; i < count; ++i) list[i].c[k] = next(list[i], k);
}

// Coefficient k of what a node is worth, after `run`.
template <class T>
T coefficient(const Tape<T>& tape, int i, int k) {
  const NodeFacts<T>& f = tape.node[source(tape, i)];
  if (f.form == Form::curved) return f.c[k];
  T s = k == 0 ? f.level : T(0.0);
  if (f.form == Form::affine) add_product(s, f.slope, tape.reads.base[k]);
  return s;
}

}  // namespace stickslip::inline STICKSLIP_ISA
