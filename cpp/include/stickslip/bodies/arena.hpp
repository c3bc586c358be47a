// Arrays carved from memory that the caller owns: laid out once to count, once more to place.
#pragma once

#include <cstddef>
#include <cstdint>

#include "stickslip/isa.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct Arena {
  std::byte* base = nullptr;  // null: only count
  std::size_t used = 0;

  template <class T>
  T* take(int count) {
    constexpr std::size_t line = 64;
    T* out = base == nullptr ? nullptr : reinterpret_cast<T*>(base + used);
    used += (static_cast<std::size_t>(count) * sizeof(T) + line - 1) / line * line;
    return out;
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
