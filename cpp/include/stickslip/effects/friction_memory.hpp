// Kinetic friction depends on |w|, tau w' = v - w, w = 0 in stick; its side is the sign of w.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct FrictionMemory {
  static constexpr Names<1> parameters{"tau"};
  static constexpr Hidden hidden{"w", 0};

  template <class T>
  static T argument(const At<FrictionMemory, T>& at, int k) {
    return at.hidden()[k] * static_cast<double>(at.side());
  }
  template <class T>
  static T rate(const At<FrictionMemory, T>& at, int k) {
    return at.contact() == 0 ? T(0.0) : (at.v()[k] - at.hidden()[k]) / at["tau"];
  }
  template <class T>
  static const T* decides(const At<FrictionMemory, T>& at) {
    return at.contact() == 0 ? nullptr : at.hidden();
  }

  template <class T>
  static void watch(const At<FrictionMemory, T>& at, int order) {
    if (at.contact() != 0) above(at.watch(at.u(), 1.0, order), T(0.0));
  }
  template <class T>
  static void slips(const Turn<FrictionMemory, T>& turn) {
    const double w = plain(turn.hidden());
    const auto& b = branch_of(turn.sys, turn.mode.contact);
    turn.side() = w == 0 ? turn.mode.contact : (w < 0 ? -1 : 1);
    turn.mode.saturated = b.has_kink && std::abs(w) >= plain(b.kink);
    if (w == 0) turn.stands_inside();
  }
  template <class T>
  static void cross(const Turn<FrictionMemory, T>& turn, auto through) {
    turn.side() = -turn.side();
    turn.stands() = through;
  }
  template <class T>
  static void changes(const Turn<FrictionMemory, T>& turn, int before) {
    const int now = turn.mode.contact;
    if (before == 0 || now != -before) turn.hidden() = T(0.0);  // from slip to slip the other way it runs on
    if (now != 0) slips(turn);
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
