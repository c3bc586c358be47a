// Powers that are no whole numbers, of what is 0 at the start: u^1.3 as slip begins.
#pragma once

#include "stickslip/bodies/step.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Is there a power of 0 in what moves the rig?
template <class T>
bool starts_at_zero(const BodiesSystem<T>& sys) {
  for (int j = 0; j < sys.contacts; ++j) {
    const Tape<T>& tape = tape_of(sys.contact[j]);
    for (int i = 0; i < tape.inners; ++i)
      if (tape.inner[i].code == Code::power && value(tape.inner[i].a[0]) == 0) return true;
  }
  return false;
}

template <class T>
void set_powers(BodiesSystem<T>& sys, int order, double h, bool flat) {
  for (int j = 0; j < sys.contacts; ++j) {
    Tape<T>& tape = tape_of(sys.contact[j]);
    for (int i = 0; i < tape.inners; ++i) {
      Instruction<T>& in = tape.inner[i];
      if (in.code != Code::power || value(in.a[0]) != 0) continue;
      in.aux[1] = in.aux[2] = T(0.0);
      if (flat) continue;
      Real<T> c[series_size];
      for (int k = 0; k <= order; ++k) c[k] = value(in.a[k]);
      const int m = departure_order(c, order, Real<T>(h));
      const T leads = in.a[m] * std::pow(h, m), power = in.x * static_cast<double>(m);
      if (!(value(leads) > 0)) continue;
      const T size = raised(leads, in.x);
      const T slope = power * 6.0 / ((power + 1.0) * (power + 2.0));
      in.aux[1] = size * (T(1.0) / (power + 1.0) - slope * 0.5);
      in.aux[2] = size * slope / h;
    }
  }
}

// The largest of those powers at h.
template <class T>
double largest_power(const BodiesSystem<T>& sys) {
  double most = 0;
  for (int j = 0; j < sys.contacts; ++j) {
    const Tape<T>& tape = tape_of(sys.contact[j]);
    for (int i = 0; i < tape.inners; ++i) {
      const Instruction<T>& in = tape.inner[i];
      if (in.code == Code::power && value(in.a[0]) == 0)
        most = std::max(most, std::abs(static_cast<double>(value(in.aux[1]))));
    }
  }
  return most;
}

// Expands a piece that starts at such a power. The line in its place has the power's mean and first moment over the step,
// so that what is left is of second order in it: h is short enough for that. Returns the step.
template <class T>
double expand_at_zero(BodiesSystem<T>& sys, int order, double rtol, double atol, double h) {
  set_powers(sys, order, h, true);
  expand_bodies(sys, order);
  Real<T> allowed[64];
  allowed_speeds(sys, rtol, atol, allowed);
  double pace = static_cast<double>(sys.rate + sys.frequency);
  double share = 0;  // of what is allowed, that the acceleration takes in unit time
  for (int i = 0; i < sys.n; ++i) {
    share = std::max(share, std::abs(static_cast<double>(value(sys.v[i * series_size + 1]) / allowed[i])));
    for (int j = 0; j < sys.contacts; ++j)
      share = std::max(share, std::abs(static_cast<double>(value(sys.reach[j * sys.n + i]) *
                                                           value(sys.force[j * series_size]) / allowed[i])));
  }
  h = std::min(h, pace > 0 ? 0.1 / pace : h);
  for (int tries = 0; tries < 200; ++tries, h *= 0.5) {
    set_powers(sys, order, h, false);
    const double size = largest_power(sys);
    if (share * h * size * std::max(size, h * pace) <= tolerance_share) break;
  }
  expand_bodies(sys, order);
  return h;
}

}  // namespace stickslip::inline STICKSLIP_ISA
