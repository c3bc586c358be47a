// What derivatives by the exponents of powers ask of a step.
#pragma once

#include "stickslip/bodies/system.hpp"
#include "stickslip/tolerance.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Calls f(tape) for the formulas in use of every contact.
template <class T, class F>
void each_tape_in_use(const BodiesSystem<T>& sys, F&& f) {
  for (int j = 0; j < sys.contacts; ++j)
    for (int s = 0; s < 2; ++s)
      if (sys.contact[j].mode == sticks || s == (sys.contact[j].mode > 0)) f(sys.contact[j].tape[s]);
}

// Shortens a step for the derivatives by exponents. Where a^p is a polynomial, p being whole, its own terms do not show how
// near a = 0 is, but those of its derivative by p do: a^p log a. `share` is what friction pulls with over the allowed.
template <class T>
Real<T> step_by_exponents(const BodiesSystem<T>& sys, double share, int order, Real<T> h) {
  each_tape_in_use(sys, [&](const Tape<T>& tape) {
    for (int n = 0; n < tape.inners; ++n) {
      const Instruction<T>& in = tape.inner[n];
      if (in.code != Code::power || is_plain(in.x) || !(value(in.a[0]) > 0)) continue;
      double log[series_size], term[series_size];
      const auto plain = [](const T& x) { return static_cast<double>(value(x)); };
      for (int k = 0; k <= order; ++k) {
        double sum = 0;
        for (int j = 1; j < k; ++j) sum += j * log[j] * plain(in.a[k - j]);
        log[k] = k == 0 ? std::log(plain(in.a[0])) : (plain(in.a[k]) - sum / k) / plain(in.a[0]);
        term[k] = 0;
        for (int j = 0; j <= k; ++j) term[k] += log[j] * plain(in.c[k - j]);
      }
      h = shortened(h, [&](int, double step) {
        const double last = std::abs(term[order]) * step, before = std::abs(term[order - 1]);
        return std::max(last, before) * std::pow(step, order) * share <= tolerance_share;
      });
    }
  });
  return h;
}

}  // namespace stickslip::inline STICKSLIP_ISA
