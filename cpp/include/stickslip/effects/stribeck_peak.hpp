// dT e^(-(u/v_s)^2) on R(u), and dT on the static limits.
#pragma once

#include "stickslip/effect.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct StribeckPeak {
  static constexpr Names<2> parameters{"dT", "v_s"};

  template <class T>
  struct Series {
    T square[series_size], slope[series_size], peak[series_size];
  };
  template <class T>
  static T magnitude(const At<StribeckPeak, T>& at, int k) {
    auto& own = at.own();
    const T over = T(1.0) / (at["v_s"] * at["v_s"]);
    own.square[k] = product(at.u(), at.u(), k);
    if (k > 0) own.slope[k] = -(own.square[k] * over) * static_cast<double>(k);
    own.peak[k] = k == 0 ? at["dT"] * exponential(-(own.square[0] * over)) : exponential_next(own.slope, own.peak, k);
    return own.peak[k];
  }
  template <class T>
  static T limit(const At<StribeckPeak, T>& at, int k) {
    return constant(at["dT"], k);
  }

  // A narrow peak ahead hides from the last terms: far from it e^a is nothing, and its series only starts to grow. With
  // X = sum |a_k| h^k the terms left out are below e^(a_0) X^p/p! (e^X beyond X = p): shorten h until that is allowed.
  template <class T>
  static Real<T> shorten(const At<StribeckPeak, T>& at, int order, const Real<T>& h, const Real<T>& allowed) {
    if (at.contact() == 0) return h;
    return shortened(h, [&](int i, double step) {
      const auto real = [&](const T& x) { return lane(value(x), i); };
      const double u = real(at.u()[0]) / real(at["v_s"]);
      double tall = std::abs(real(at["dT"]));
      if constexpr (requires(T x) { x.d[0]; })  // one of no height is differentiated by it
        for (int k = 0; k < T::size; ++k) tall = largest(tall, std::abs(at["dT"].derivative(k)));
      const double height = tall * std::abs(real(at.sys.rig.over_a1)) + 1e-300;
      double x = 0;
      for (int k = order; k >= 1; --k) x = (x + std::abs(real(at.own().slope[k])) / k) * step;
      const double grown = x < order ? order * std::log(x + 1e-300) - std::lgamma(order + 1.0) : x;
      return grown <= std::log(lane(allowed, i) / height) + u * u;
    });
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
