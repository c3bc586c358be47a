// How long a step of a tape and its surfaces may be.
#pragma once

#include "stickslip/bodies/run_tape.hpp"
#include "stickslip/step.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// For surfaces at which the force is continuous, what is left out moves the motion by its square.
constexpr double surface_share = 0.01;
inline double surface_tolerance(double rtol) { return surface_share * std::sqrt(rtol); }

// The step that keeps the last two terms of a series within `scale`.
template <class T>
Real<T> step_of(const T* c, const Real<T>& scale, int order, double rtol, double atol) {
  return step_from<T>(magnitude(value(c[order])), magnitude(value(c[order - 1])), scale, order, rtol, atol);
}

// A power that is whole, of what is next to 0: with more factors than the series has terms it is nothing in all of them.
// It may grow to no more than the allowed, or its base by a share of itself.
template <class T>
bool power_seen(const Instruction<T>& in, int order, double step, double height) {
  const double p = static_cast<double>(value(in.x)), start = std::abs(static_cast<double>(value(in.a[0])));
  int first = 0;  // order of the first term that moves the base
  double moves = 0, term[series_size], power = 1;
  for (int k = 0; k <= order; ++k, power *= step) {
    term[k] = std::abs(static_cast<double>(value(in.a[k]))) * power;
    if (k > 0) moves += term[k];
  }
  for (int k = 1; k <= order && first == 0; ++k)
    if (term[k] >= 1e-3 * moves) first = k;
  if (p * first <= order - 2 || moves <= 0.5 * order / (p * first) * start) return true;
  return p * std::log(start + moves + 1e-300) + std::log(height) <= 0;
}

// Functions whose nearest singularity hides from the last terms when it is far off: tanh, asinh; and exponentials that
// are next to nothing but grow. `height` of an exponential is what it weighs beside the allowed.
template <class T>
Real<T> hidden_step(const Instruction<T>* list, int count, int order, Real<T> h, double height) {
  for (int i = 0; i < count; ++i) {
    const Instruction<T>& in = list[i];
    if (in.code == Code::whole_power)
      h = shortened(h, [&](int, double step) { return power_seen(in, order, step, height); });
    const bool root = in.code == Code::asinh, tanh = in.code == Code::tanh, grows = in.code == Code::exponential;
    if (!root && !tanh && !grows) continue;
    const double start = static_cast<double>(value(in.a[0]));
    const double by = grows ? std::abs(static_cast<double>(value(in.x))) : 1.0;
    const auto moves = [&](double step) {
      double x = 0;
      for (int k = order; k >= 1; --k) x = (x + std::abs(static_cast<double>(value(in.a[k])))) * step;
      return x * by;
    };
    const double reach = tanh ? 2.467 : 1.0;  // (pi/2)^2, 1: the square of how far it is beside the real axis
    const double own = static_cast<double>(value(in.c[0]));
    if (grows && own * own * height > 1) continue;  // seen
    h = shortened(h, [&](int, double step) {
      const double x = moves(step);
      if (!grows) return x <= 0.3 * std::sqrt(start * start + reach);
      const double grown = x < order ? order * std::log(x + 1e-300) - std::lgamma(order + 1.0) : x;
      return grown + std::log(own * height + 1e-300) <= 0;
    });
  }
  return h;
}

// The step that a tape and its surfaces allow; `near` is the tolerance of the surfaces, `top` their order.
template <class T>
Real<T> step_of_tape(const Tape<T>& tape, int order, int top, double near, double atol, Real<T> h, double height) {
  using R = Real<T>;
  h = hidden_step(tape.inner, tape.inners, order, h, height);
  h = hidden_step(tape.outer, tape.outers, top, h, height);
  for (int i = 0; i < tape.surface_count; ++i) {
    const Node& one = tape.at(tape.surfaces[i]);
    const auto now = [&](int k) {  // when it was linked, or at present: one of the two may be passing through 0
      return largest(R(magnitude(tape.node[k].now)), R(magnitude(value(coefficient(tape, k, 0)))));
    };
    const R scale = largest(now(one.a), now(is_binary(one.op) ? one.b : one.a));
    h = smallest(h, step_of(tape.surface_series + i * series_size, scale, top, near, atol));
  }
  return h;
}

}  // namespace stickslip::inline STICKSLIP_ISA
