// What curves do: an effect E that is curve `which` of a model, g of one variable, a cubic spline through values at knots
// (table.hpp), as a force on a body, or as friction times 1 + g. Its side is the interval between knots, 0 below the first;
// of a curve that repeats in t it counts on from period to period. It is then read at (w t + phi) period/(2 pi).
#pragma once

#include <numbers>

#include "stickslip/effect.hpp"

namespace stickslip_abi {

enum class TablePlace : int { block, angle_body, contact };
inline constexpr std::array<std::string_view, 3> table_places{"block", "angle_body", "contact"};
enum class TableVariable : int { x1, x2, y1, y2, v_w, t };
inline constexpr std::array<std::string_view, 6> table_variables{"x1", "x2", "y1", "y2", "v_w", "t"};
constexpr int max_knots = 24;
constexpr int table_count = 2;  // curves of a model, at most

struct Table {
  TablePlace place = TablePlace::block;
  TableVariable variable = TableVariable::x1;
  double period = 0;  // of t-phase; 0: none
  int knots = 0;      // >= 2 of a table that is there
  double knot[max_knots] = {};
};

}  // namespace stickslip_abi

namespace stickslip::inline STICKSLIP_ISA {

template <class E, int which>
struct Curve {
  static_assert(which < stickslip_abi::table_count);
  static constexpr int table = which;
  using Place = stickslip_abi::TablePlace;
  using Variable = stickslip_abi::TableVariable;
  static constexpr Names<2> parameters{"w", "phi"};

  template <class T>
  struct Series {
    T g[series_size], variable[series_size], offset[series_size], square[series_size];  // offset: from the left knot
  };

  // Whole periods passed, and the interval within one.
  static int cycle(const stickslip_abi::Table& own, int side) {
    const int per_turn = own.knots - 1, on = side - 1;
    return own.period > 0 ? on / per_turn - (on % per_turn < 0 ? 1 : 0) : 0;
  }
  static int interval(const stickslip_abi::Table& own, int side) { return side - cycle(own, side) * (own.knots - 1); }
  static const stickslip_abi::Table& of(const auto& system) { return system.structure.table[which]; }

  // Coefficient k of the time that the table is read at, and of its variable.
  template <class T>
  static T time(const At<E, T>& at, int k) {
    if (k > 1) return T(0.0);
    const double period = of(at.sys).period, turn = period / (2 * std::numbers::pi);
    if (!(period > 0)) return k == 0 ? at.t() : T(1.0);
    if (k == 1) return at["w"] * turn;
    return (at["w"] * at.t() + at["phi"]) * turn - cycle(of(at.sys), at.side()) * period;
  }
  template <class T>
  static T variable(const At<E, T>& at, int k) {
    switch (of(at.sys).variable) {
      case Variable::x1: return at.x1()[k];
      case Variable::x2: return at.x2()[k];
      case Variable::y1: return at.y1()[k];
      case Variable::y2: return at.y2()[k];
      case Variable::v_w: return at.v()[k];
      default: return time(at, k);
    }
  }

  template <class T>
  static void prepare(const At<E, T>& at, int k) {
    auto& own = at.own();
    const auto& declared = of(at.sys);
    const int i = interval(declared, at.side());
    const T* c = at.sys.table[which][i];
    own.variable[k] = variable(at, k);
    if (i == 0 || i == declared.knots) {
      own.g[k] = constant(c[0], k);
      return;
    }
    own.offset[k] = own.variable[k] - constant(T(declared.knot[i - 1]), k);
    const T cubic = cube_next(own.offset, own.square, k);
    own.g[k] = constant(c[0], k) + c[1] * own.offset[k] + c[2] * own.square[k] + c[3] * cubic;
  }
  template <class T>
  static bool shares(const At<E, T>& at) {
    return of(at.sys).place == Place::contact;
  }
  template <class T>
  static T acting(const At<E, T>& at, Place place, int k) {
    return of(at.sys).place == place ? at.own().g[k] : T(0.0);
  }
  template <class T>
  static T block(const At<E, T>& at, int k) {
    return acting(at, Place::block, k);
  }
  template <class T>
  static T angle_body(const At<E, T>& at, int k) {
    return acting(at, Place::angle_body, k);
  }
  template <class T>
  static T share(const At<E, T>& at, int k) {
    return at.own().g[k];
  }

  template <class T>
  static void watch(const At<E, T>& at, int order) {
    const auto& own = of(at.sys);
    const int i = interval(own, at.side());
    auto& w = at.watch(at.own().variable, 1.0, order);
    if (own.variable == Variable::x2 || own.variable == Variable::y2) w.rounding = at.speed_rounding();
    if (i > 0) above(w, T(own.knot[i - 1]));
    if (i < own.knots) below(w, T(own.knot[i]));
  }
  template <class T>
  static void start(const Turn<E, T>& turn) {
    const auto& own = of(turn.sys);
    const bool repeats = own.period > 0;
    const int n = own.knots, last = repeats ? n - 1 : n;
    turn.side() = repeats ? 1 : 0;
    const double x = plain(variable(turn.at(), 0));
    const int turns = repeats ? static_cast<int>(std::floor(x / own.period)) : 0;
    const double within = repeats ? x - turns * own.period : x;
    int i = turn.side();
    while (i < last && within >= own.knot[i]) ++i;
    turn.side() = turns * (n - 1) + i;
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
