// Powers that are no whole numbers, of what is 0 at the start: u^1.3 as slip begins.
#pragma once

#include "stickslip/bodies/step.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Calls f(contact, instruction) for every power of 0 in what moves the rig; of a push the contact is -1.
template <class T, class F>
void each_power_of_zero(BodiesSystem<T>& sys, F&& f) {
  for (int j = 0; j < sys.contacts; ++j) {
    Tape<T>& tape = tape_of(sys.contact[j]);
    for (int i = 0; i < tape.inners; ++i)
      if (tape.inner[i].code == Code::power && of_zero(tape.inner[i])) f(j, tape.inner[i]);
  }
  for (int e = 0; e < sys.pushes; ++e) {
    Tape<T>& tape = sys.push[e].tape;
    for (int i = 0; i < tape.inners; ++i)
      if (tape.inner[i].code == Code::power && of_zero(tape.inner[i])) f(-1, tape.inner[i]);
  }
}
template <class T>
bool starts_at_zero(BodiesSystem<T>& sys) {
  bool any = false;
  each_power_of_zero(sys, [&](int, const auto&) { any = true; });
  return any;
}

// The order m of the first term of a series that starts at 0, and that term at h.
template <class T>
int first_term(const T* a, int order, double h, T& term) {
  Real<T> c[series_size];
  for (int k = 0; k <= order; ++k) c[k] = value(a[k]);
  const int m = departure_order(c, order, Real<T>(h));
  term = a[m] * std::pow(h, m);
  return m;
}

// a starts as a_m t^m, so that a^x starts as t^p, p = m x. Over [0, h] two powers of t with whole exponents on either side of
// p stand for it, with the same mean and the same first moment: what they do to q' and q at h is the same.
template <class T>
void fit_power(Instruction<T>& in, int order, double h) {
  for (int k = 0; k <= order; ++k) in.aux[1 + k] = T(0.0);
  T term(0.0);
  const T p = in.x * static_cast<double>(first_term(in.a, order, h, term));
  const double below = std::floor(static_cast<double>(value(p)));
  const int i = static_cast<int>(below);
  if (!(value(term) > 0) || i + 1 > order) return;
  const T share = raised(term, in.x) / ((p + 1.0) * (p + 2.0));
  in.aux[1 + i] = share * (below + 1.0 - p) * ((below + 1.0) * (below + 2.0) / std::pow(h, i));
  in.aux[2 + i] = share * (p - below) * ((below + 2.0) * (below + 3.0) / std::pow(h, i + 1));
}

constexpr double lost_in_rounding = 1e-14;  // of the speeds that u is the difference of

// Expands a piece that starts at such a power, in a step short enough that what the fit leaves out is below the tolerance:
// of second order in the power, or in time, or in how much the power itself moves u (where friction does not drop at the
// onset, u starts as t^2 and an error in it shifts the slip in time). Returns the step.
template <class T>
double expand_at_zero(BodiesSystem<T>& sys, int order, double rtol, double atol, double h) {
  const auto real = [](const T& x) { return std::abs(static_cast<double>(value(x))); };
  each_power_of_zero(sys, [&](int, Instruction<T>& in) {
    for (int k = 0; k <= order; ++k) in.aux[1 + k] = T(0.0);
  });
  expand_bodies(sys, order);
  Real<T> allowed[64];
  allowed_speeds(sys, rtol, atol, allowed);
  const double pace = static_cast<double>(sys.rate + sys.frequency);
  double pull = 0, share = 0;  // acceleration by friction; as a share of what is allowed
  for (int i = 0; i < sys.n; ++i) {
    double by = real(sys.v[i * series_size + 1]);
    for (int j = 0; j < sys.contacts; ++j)
      by = std::max(by, real(sys.reach[j * sys.n + i] * sys.force[j * series_size]));
    pull = std::max(pull, by);
    share = std::max(share, by / static_cast<double>(allowed[i]));
  }
  h = std::min(h, pace > 0 ? 0.1 / pace : h);
  for (int tries = 0; tries < 100; ++tries, h *= 0.5) {
    double error = 0;
    bool lost = false;
    each_power_of_zero(sys, [&](int j, Instruction<T>& in) {
      T term(0.0), slip(0.0);
      first_term(in.a, order, h, term);
      if (j < 0) {
        const double size = std::pow(real(term), static_cast<double>(value(in.x)));
        error = std::max(error, share * h * size * std::max(size, h * pace));
        return;
      }
      const int m = first_term(sys.u + j * series_size, order, h, slip);
      const double size = std::pow(real(term), static_cast<double>(value(in.x))),
                   back = pull * size * h / (real(slip) + 1e-300);
      error = std::max(error,
                       share * h * std::max(size * std::max(size, h * pace), m > 1 ? std::min(1.0, back * back) : 0.0));
      const int speed = sys.contact[j].speed;
      lost = lost || (m > 1 && speed >= 0 && real(slip) < lost_in_rounding * real(sys.V[speed * series_size]));
    });
    if (error <= tolerance_share || lost) break;
  }
  each_power_of_zero(sys, [&](int, Instruction<T>& in) { fit_power(in, order, h); });
  expand_bodies(sys, order);
  return h;
}

}  // namespace stickslip::inline STICKSLIP_ISA
