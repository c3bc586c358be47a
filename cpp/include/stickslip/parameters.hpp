// A model's numbers in the number type of the computation.
#pragma once

#include "stickslip/interface.hpp"
#include "stickslip/numbers.hpp"

namespace stickslip::inline STICKSLIP_ISA {

using namespace stickslip_abi;  // NOLINT(google-build-using-namespace): plain data shared by every build

template <class T>
struct Parameters {
  T p[parameter_count];
  const T& operator[](int slot) const { return p[slot]; }
  T& operator[](int slot) { return p[slot]; }
};

// Slot values of a request, seeded for differentiation: row s of `seeds` holds the weight of every slot.
template <class T>
void load(const double* values, const double* seeds, int first, int count, int stride, T* out, int n) {
  for (int i = 0; i < n; ++i) out[i] = T(values[i]);
  if constexpr (requires(T x) { x.d[0]; }) {
    for (int s = 0; s < count; ++s)
      for (int i = 0; i < n; ++i) out[i].set_derivative(s, seeds[(first + s) * stride + i]);
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
