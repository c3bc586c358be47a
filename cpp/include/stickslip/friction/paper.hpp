// The paper's law. T_- is (4.2) with the exponent 0.28 - u and the floor T_min, T_+ the line (4.1) with its floor.
#pragma once

#include "stickslip/branch.hpp"
#include "stickslip/names.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct Paper {
  static constexpr Names<10> parameters{"T_s_minus", "A1",          "A2",       "t1",         "t2",
                                        "v_w_min",   "T_min_minus", "T_s_plus", "T_min_plus", "v_w_max"};
  enum Own : int { a1, k1, a2, k2 };  // of -a1 e^(k1 u) - a2 e^(k2 u)

  template <class T>
  static Branch<T> branch(const Numbers<Paper, T>& p, int direction) {
    return direction < 0 ? minus(p) : plus(p);
  }
  template <class T>
  static Branch<T> minus(const Numbers<Paper, T>& p) {  // (4.2)
    Branch<T> b{};
    b.static_limit = b.c0 = p["T_s_minus"];
    b.own[k1] = T(1.0) / p["t1"];
    b.own[k2] = T(1.0) / p["t2"];
    b.own[a1] = p["A1"] * exponential(p["v_w_min"] * b.own[k1]);  // v_w_min = -0.28: e^(-(0.28 - u)/t1)
    b.own[a2] = p["A2"] * exponential(p["v_w_min"] * b.own[k2]);
    b.saturated = p["T_min_minus"];
    b.has_kink = true;
    b.curve = own_curve;
    b.kink = saturation_speed<Paper>(b, -static_cast<double>(value(p["v_w_min"])));
    return b;
  }
  template <class T>
  static Branch<T> plus(const Numbers<Paper, T>& p) {  // (4.1)
    Branch<T> b{};
    b.static_limit = b.c0 = p["T_s_plus"];
    b.c1 = (p["T_min_plus"] - p["T_s_plus"]) / p["v_w_max"];
    b.saturated = p["T_min_plus"];
    b.has_kink = true;
    b.kink = p["v_w_max"];
    return b;
  }

  template <class T>
  static T curve(const T* own, const T& u) {
    return -(own[a1] * exponential(own[k1] * u)) - own[a2] * exponential(own[k2] * u);
  }
  template <class T>
  static T slope(const T* own, const T& u) {
    return -(own[a1] * own[k1] * exponential(own[k1] * u)) - own[a2] * own[k2] * exponential(own[k2] * u);
  }

  template <class T>
  struct Series {
    T slope[series_size], e1[series_size], e2[series_size];  // k u_k; both exponentials
  };
  // Coefficient k of the curve along u(t).
  template <class T>
  static T next(const T* own, const T* u, Series<T>& s, int k) {
    if (k > 0) s.slope[k] = u[k] * static_cast<double>(k);
    s.e1[k] = k == 0 ? own[a1] * exponential(own[k1] * u[0]) : exponential_next(s.slope, s.e1, k) * own[k1];
    s.e2[k] = k == 0 ? own[a2] * exponential(own[k2] * u[0]) : exponential_next(s.slope, s.e2, k) * own[k2];
    return -s.e1[k] - s.e2[k];
  }

  // A whole piece without effects. The recurrence is a chain of dependent operations, so all that does not need the
  // newest coefficient is formed beside it: e holds (a_i/a1) e^(k_i u), `other` the part of u' without e, and each turn
  // of the chain is one sum and one multiply-add.
  template <class R, class T>
  static void expand(const R& r, const Branch<T>& b, const Real<T>& dir, int order, auto& s) {
    T slope[series_size];  // slope[k] = k u_k
    Pair<T> e[series_size];
    const T damping = r.e1 * r.over_a1, stiffness = r.kx * dir, y_damping = damping * dir,
            y_stiffness = r.s * r.over_a1 * dir;
    const T b3 = r.b3 * r.over_a2, e12 = r.e12 * r.over_a2, leg1 = r.over_a2, leg2 = r.e1 * r.over_a2;
    const Pair<T> rate = paired(b.own[k1], b.own[k2]);
    T x1 = s.x1[0], x2 = s.x2[0], y1 = s.y1[0], y2 = s.y2[0], u = (x2 - r.v_b) * dir;
    e[0] = paired(T(b.own[a1] * r.over_a1), T(b.own[a2] * r.over_a1)) * exponential(rate * u);
    const Pair<T> first = e[0] * rate;
    Pair<T> newest = e[0];
    T other = -(b.c0 * r.over_a1) - damping * (x2 * dir - u);  // of u' : all but e and the terms below
    for (int k = 0; k < order; ++k) {
      const Real<T> over = inverse<T>(k + 1);
      Pair<T> rest(0.0);
      if (k > 0) rest = exponential_rest(slope, e, k + 1) * (rate * over);
      other = other - (stiffness * x1 + y_damping * y2 + y_stiffness * y1);
      const T leg = (b3 * y1 + e12 * y2 + leg1 * x1 + leg2 * x2) * over;
      x1 = x2 * over;
      y1 = y2 * over;
      y2 = -leg;
      const T next = (other - damping * u) + sum(newest);
      slope[k + 1] = next;
      newest = rest + first * (next * over);
      e[k + 1] = newest;
      u = next * over;
      x2 = u * dir;
      s.x1[k + 1] = x1;
      s.x2[k + 1] = x2;
      s.y1[k + 1] = y1;
      s.y2[k + 1] = y2;
      other = T(0.0);
    }
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
