// How long a step of a run with derivatives may be: their own series against the tolerance, as of a named rig
// (derivative_step.hpp). A bristle in steady sliding is constant; its derivative by its start dies out fast.
#pragma once

#include "stickslip/bodies/step.hpp"
#include "stickslip/derivative_step.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Shortens h until the last two terms of each derivative of each state are below the tolerance beside the largest term of
// that state's, or beside a share of the state's own scale.
template <class T>
double bodies_derivative_step(const BodiesSystem<T>& sys, int order, double h, double rtol) {
  const double frequency = static_cast<double>(sys.frequency);
  double top = 0;
  for (int i = 0; i < sys.n; ++i) {  // a speed of the motion, by energy
    const double by = static_cast<double>(sys.weight[i]);
    top = std::max(top, by * std::abs(sys.v[i * series_size].v));
    top = std::max(top, by * frequency * std::abs(sys.q[i * series_size].v));
  }
  const BySeed<T> change = change_by_seed(sys.values, sys.at.size);
  const auto shorten = [&](const T* series, double scale) {
    const BySeed<T> floors = derivative_floors(change, scale);
    const auto allows = [&](int, double step) {
      BySeed<T> most = floors, last(0.0);
      const double power = std::pow(step, order - 1);
      last.raise(series[order - 1], power);
      last.raise(series[order], power * step);
      const auto small = [&] { return last.below(most, derivative_share * rtol); };
      double now = 1;
      for (int k = 0; k < order - 1; ++k, now *= step) {
        most.raise(series[k], now);
        if (k < 2 && small()) return true;  // nearly always
      }
      return small();
    };
    h = shortened(h, allows);
  };
  for (int i = 0; i < sys.n; ++i) shorten(sys.v + i * series_size, top / static_cast<double>(sys.weight[i]));
  for (int i = 0; i < sys.states; ++i) shorten(sys.z + i * series_size, std::abs(sys.z[i * series_size].v));
  return h;
}

// The step that the motion allows, and its derivatives where there are any.
template <class T>
Real<T> step_with_derivatives(const BodiesSystem<T>& sys, const Curves<T>& curves, int order, double rtol, double atol,
                              const Real<T>& left) {
  Real<T> h = step_of_bodies(sys, curves, order, rtol, atol, left);
  if constexpr (requires(T x) { x.d[0]; })
    if (curves.motion || curves.others) h = bodies_derivative_step(sys, order, h, rtol > 0 ? rtol : atol);
  return h;
}

}  // namespace stickslip::inline STICKSLIP_ISA
