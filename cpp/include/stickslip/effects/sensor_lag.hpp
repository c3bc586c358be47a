// The reading of x1 is m, tau m' = reading - m. The motion does not feel it.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct SensorLag {
  static constexpr Names<1> parameters{"tau"};
  static constexpr Hidden hidden{"m", 3};

  template <class T>
  struct Series {
    T reads[series_size], rest;  // what it follows; the part of m that dies out as e^(-t/tau), beside the series
    bool settled;
  };
  template <class T>
  static T rate(const At<SensorLag, T>& at, int k) {
    auto& own = at.own();
    own.settled = false;
    own.reads[k] = at.reading(k);
    return (own.reads[k] - at.hidden()[k]) / at["tau"];
  }
  template <class T>
  static T state(const At<SensorLag, T>& at, const T& m, const T& h) {
    const auto& own = at.own();
    return own.settled ? m + own.rest * exponential(-(h / at["tau"])) : m;
  }

  // Its equation is linear and it only reads the motion: where tau is shorter than the motion's own step h, m is the
  // polynomial that follows what is read, m_k = reads_k - tau (k + 1) m_(k+1), and a rest that dies out as e^(-t/tau).
  // Otherwise m is a series like the others and h is held to its last terms.
  template <class T>
  static void settle(const At<SensorLag, T>& at, int order, Real<T>& h, double rtol, double atol) {
    using R = Real<T>;
    auto& own = at.own();
    T* m = at.hidden();
    const T tau = at["tau"];
    const auto slow = greater(value(tau), h);
    const auto size = [&](int k) { return R(magnitude(value(m[k]))); };
    h = select(slow, R(smallest(h, step_from<T>(size(order), size(order - 1), at.motion_scale(), order, rtol, atol))),
               h);
    own.settled = true;
    const T start = m[0];
    T follows = own.reads[order];
    m[order] = select(slow, m[order], follows);
    for (int k = order - 1; k >= 0; --k) {
      follows = own.reads[k] - tau * follows * static_cast<double>(k + 1);
      m[k] = select(slow, m[k], follows);
    }
    own.rest = start - m[0];
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
