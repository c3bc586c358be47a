// The hyperbolic law: R(u) = scale/(1 + decay u) + constant + quadratic u^2; at rest it holds R(0).
#pragma once

#include "stickslip/branch.hpp"
#include "stickslip/names.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct Hyperbolic {
  static constexpr Names<8> parameters{"scale_minus", "decay_minus", "constant_minus", "quadratic_minus",
                                       "scale_plus",  "decay_plus",  "constant_plus",  "quadratic_plus"};
  enum Own : int { scale, decay, quadratic };

  template <class T>
  static Branch<T> branch(const Numbers<Hyperbolic, T>& p, int direction) {
    const bool minus = direction < 0;
    Branch<T> b{};
    b.curve = own_curve;
    b.c0 = minus ? p["constant_minus"] : p["constant_plus"];
    b.own[scale] = minus ? p["scale_minus"] : p["scale_plus"];
    b.own[decay] = minus ? p["decay_minus"] : p["decay_plus"];
    b.own[quadratic] = minus ? p["quadratic_minus"] : p["quadratic_plus"];
    b.static_limit = b.own[scale] + b.c0;
    return b;
  }

  template <class T>
  static T curve(const T* own, const T& u) {
    return own[quadratic] * u * u + own[scale] / (T(1.0) + own[decay] * u);
  }
  template <class T>
  static T slope(const T* own, const T& u) {
    const T d = T(1.0) + own[decay] * u;
    return 2.0 * u * own[quadratic] - own[scale] * own[decay] / (d * d);
  }

  template <class T>
  struct Series {
    T divisor[series_size], quotient[series_size], over;
  };
  // Coefficient k of the curve along u(t).
  template <class T>
  static T next(const T* own, const T* u, Series<T>& s, int k) {
    s.divisor[k] = constant(T(1.0), k) + own[decay] * u[k];
    if (k == 0) {
      s.over = T(1.0) / s.divisor[0];
      s.quotient[0] = own[scale] * s.over;
    } else {
      s.quotient[k] = quotient_next(T(0.0), s.divisor, s.quotient, s.over, k);
    }
    return s.quotient[k] + own[quadratic] * product(u, u, k);
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
