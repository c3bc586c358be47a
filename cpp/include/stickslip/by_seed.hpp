// Sizes, one for each seed of a number with derivatives, all seeds at once.
#pragma once

#include "stickslip/numbers.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
struct BySeed {
  using Chunk = typename T::Chunk;
  Chunk of[T::chunks];

  explicit BySeed(double every) {
    for (Chunk& one : of) one = every - Chunk{};
  }
  // At least the derivatives of x, `by` times.
  void raise(const T& x, double by) {
    for (int i = 0; i < T::chunks; ++i) {
      const Chunk size = (x.d[i] < 0 ? -x.d[i] : x.d[i]) * by;
      of[i] = size > of[i] ? size : of[i];
    }
  }
  void raise(const BySeed& least) {
    for (int i = 0; i < T::chunks; ++i) of[i] = of[i] > least.of[i] ? of[i] : least.of[i];
  }
  // Is none above `share` of its like? What is not finite is not known to be.
  bool below(const BySeed& like, double share) const {
    typename Register<4>::Bits above{};
    for (int i = 0; i < T::chunks; ++i) above |= of[i] > like.of[i] * share;
    return (above[0] | above[1] | above[2] | above[3]) == 0;
  }
};

// What a change of each of n numbers by itself, or by 1 if it is less, is of each seed.
template <class T>
BySeed<T> change_by_seed(const T* numbers, int n) {
  BySeed<T> size(1.0);
  for (int i = 0; i < n; ++i) size.raise(numbers[i], std::abs(numbers[i].v));
  return size;
}

}  // namespace stickslip::inline STICKSLIP_ISA
