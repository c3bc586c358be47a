// -f sgn(y2) on the angle body, which may stick. Its side: the sign of y2, 0 stuck.
//
// With a creep speed v_c the sign is tanh(y2/v_c) where |y2| < creep_reach v_c, side 0, and the sign itself beyond: there
// they differ by 1e-17.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct PivotDryFriction {
  static constexpr Names<2> parameters{"f", "v_c"};
  static constexpr double creep_reach = 20;

  template <class T>
  static bool creeps(const Numbers<PivotDryFriction, T>& p) {
    return lane(value(p["v_c"]), 0) > 0;
  }
  template <class T>
  static bool variant(const Numbers<PivotDryFriction, T>& p) {
    return creeps(p);
  }

  template <class T>
  struct Series {
    T net[series_size];                                           // the force of all the rest
    T slope[series_size], creep[series_size], rest[series_size];  // y2/v_c, its tanh, 1 - tanh^2
  };
  template <class T>
  static T pivot(const At<PivotDryFriction, T>& at, const T& net, int k) {
    auto& own = at.own();
    own.net[k] = net;
    const bool creeping = creeps(at.numbers());
    if (at.side() != 0) return net - constant(at["f"] * static_cast<double>(at.side()), k);
    if (!creeping) return T(0.0);
    const T a = at.y2()[k] / at["v_c"];
    own.slope[k] = k == 0 ? a : a * static_cast<double>(k);
    if (k == 0) {
      const T e = exponential(a * 2.0);
      own.creep[0] = (e - T(1.0)) / (e + T(1.0));
    } else {
      own.creep[k] = rotation_next(own.slope, own.rest, k);
    }
    own.rest[k] = constant(T(1.0), k) - product(own.creep, own.creep, k);
    return net - at["f"] * own.creep[k];
  }

  template <class T>
  static void watch(const At<PivotDryFriction, T>& at, int order) {
    if (creeps(at.numbers())) {
      const T reach = at["v_c"] * creep_reach;
      auto& w = at.watch(at.y2(), 1.0, order);
      if (at.side() >= 0) above(w, at.side() > 0 ? reach : -reach);
      if (at.side() <= 0) below(w, at.side() < 0 ? -reach : reach);
    } else if (at.side() != 0) {
      auto& w = at.watch(at.y2(), at.side(), order);
      above(w, T(0.0));
      w.rounding = at.speed_rounding();
    } else {
      auto& w = at.watch(at.own().net, 1.0, order);
      above(w, -at["f"]);
      below(w, at["f"]);
    }
  }
  // Where the net force takes a body at rest.
  template <class T>
  static int side_at_rest(const Turn<PivotDryFriction, T>& turn, auto& s) {
    for (int i = 0; i < 4; ++i) state_series(turn.piece, i)[0] = s.z[i];
    turn.side() = 0;
    expand_effects(turn.sys, turn.mode, s, 0, turn.piece);
    const double net = plain(turn.at().own().net[0]), f = plain(turn["f"]);
    return net > f ? 1 : (net < -f ? -1 : 0);
  }
  template <class T>
  static void start_by_force(const Turn<PivotDryFriction, T>& turn) {
    const double y2 = plain(turn.s.z[3]);
    if (creeps(turn.numbers())) {
      const double reach = creep_reach * plain(turn["v_c"]);
      turn.side() = y2 > reach ? 1 : (y2 < -reach ? -1 : 0);
      return;
    }
    turn.side() = y2 > 0 ? 1 : -1;
    if (y2 != 0) return;
    auto copy = turn.s;
    turn.side() = side_at_rest(turn, copy);
    if (turn.side() != 0) turn.stands_inside();
  }
  template <class T>
  static void cross(const Turn<PivotDryFriction, T>& turn, auto through) {
    if (creeps(turn.numbers())) return turn.step(through);
    if (turn.side() == 0) {
      turn.side() = turn.sign_of(through);
    } else {
      turn.s.z[3] = T(0.0);
      turn.side() = side_at_rest(turn, turn.s);
    }
    if (turn.side() != 0) turn.stands_inside();
  }

  // tanh(y2/v_c) has its nearest pole pi/2 beside the real axis and hides from the last terms seen from afar: y2 may move
  // a share of its distance from there.
  template <class T>
  static Real<T> shorten(const At<PivotDryFriction, T>& at, int order, const Real<T>& h, const Real<T>&) {
    if (!creeps(at.numbers()) || at.side() != 0) return h;
    return shortened(h, [&](int i, double step) {
      const auto real = [&](const T& x) { return lane(value(x), i); };
      const double v_c = real(at["v_c"]), y2 = real(at.y2()[0]);
      double moves = 0;
      for (int k = order; k >= 1; --k) moves = (moves + std::abs(real(at.y2()[k]))) * step;
      return moves <= 0.3 * std::sqrt(y2 * y2 + v_c * v_c * 2.467);
    });
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
