// The recursion (3.1) of the paper, over time and over channels.
#pragma once

#include <cmath>
#include <cstddef>

namespace stickslip {

// Constants of  y_n = a y_{n-1} + k0 x_n + k1 x_{n-1},  n >= 1,  y_0 = 0   (3.1).
struct Recursion {
  double a;
  double k0;
  double k1;
};

// The pole inside the unit circle and everything finite: what first_order() requires.
inline bool is_stable(const Recursion& c) noexcept {
  return std::abs(c.a) < 1.0 && std::isfinite(c.k0) && std::isfinite(c.k1);
}

// (3.1) as it is written, one sample after the other: the definition the fast kernel is tested against.
inline void first_order_plain(const double* x, double* y, std::size_t n, std::size_t channels,
                              const Recursion& c) noexcept {
  for (std::size_t k = 0; k < channels && n > 0; ++k) y[k] = 0.0;
  for (std::size_t i = channels; i < n * channels; ++i) {
    y[i] = c.a * y[i - channels] + c.k0 * x[i] + c.k1 * x[i - channels];
  }
}

// (3.1) on n samples of `channels` interleaved channels (row-major n x channels).
// x and y hold n*channels values each and do not overlap; nothing is allocated. Needs is_stable(c).
// Returns false if any input is NaN or infinite (y is then of no use), true otherwise.
// Runs the variant for isa_in_use().
[[nodiscard]] bool first_order(const double* x, double* y, std::size_t n, std::size_t channels,
                               const Recursion& c) noexcept;

}  // namespace stickslip
