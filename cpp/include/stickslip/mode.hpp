// The discrete part of the state.
#pragma once

#include "stickslip/structure.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Effects with a surface, in their order.
template <class E>
concept HasSurface = requires { &E::template watch<double>; };

constexpr int surface_count = count_before<void>(Effects{}, []<class E> { return HasSurface<E>; });
template <class E>
constexpr int surface_of = count_before<E>(Effects{}, []<class Other> { return HasSurface<Other>; });

// Only `contact` and `saturated` move without effects.
struct Mode {
  int contact = 0;               // -1 slip with v_w < 0, 0 stick, 1 slip with v_w > 0
  bool saturated = false;        // the branch holds its floor
  int side[surface_count] = {};  // of each effect with a surface: where it stands, as its file says
};

// A mode as one number: members with the same one can share a batch. (Of a table in t, only one without cycles.)
inline std::uint64_t key_of(const Mode& mode) {
  static_assert(5 * surface_count + 3 <= 64);
  std::uint64_t key = mode.saturated ? 4 : 0;
  key += static_cast<std::uint64_t>(mode.contact) + 1;
  for (const int side : mode.side) key = key << 5 | (static_cast<std::uint64_t>(side) + 1);  // of a table up to 24
  return key;
}

}  // namespace stickslip::inline STICKSLIP_ISA
