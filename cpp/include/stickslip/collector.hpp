// Where one group of seeds of a recorded run writes.
#pragma once

#include <cstddef>
#include <vector>

namespace stickslip {

// Values are written the first time, derivatives into the group's columns. R is the record, with `seeds` columns in all.
template <class R>
struct Collector {
  R* out;
  std::size_t first, count;
  bool merge;  // rows at one time, as before and after a transition at the start, become one: the last
  std::size_t row = 0, event_row = 0;
  double last = 0;

  void place(std::vector<double>& all, std::size_t at, std::size_t numbers, const double* derivatives) const {
    if (out->seeds == 0) return;
    const std::size_t stride = numbers * out->seeds;
    if (all.size() < (at + 1) * stride) all.resize((at + 1) * stride);
    for (std::size_t i = 0; i < numbers; ++i)
      for (std::size_t k = 0; k < count; ++k)
        all[at * stride + i * out->seeds + first + k] = derivatives[i * count + k];
  }
};

}  // namespace stickslip
