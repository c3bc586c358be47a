// A model as plain data: its numbers in one flat vector, and what they are the numbers of. Laws and effects are those of
// friction/ and effects/, one header each; what is here is counted from the two folders.
#pragma once

#include <cstdint>

#include "stickslip/effects/all.hpp"
#include "stickslip/friction/all.hpp"

namespace stickslip_abi {

enum class RigKind : int { two_degree = 0, block_on_belt = 1 };

// Numbers of the rig (2.1), whose stiffness is what its block has beside alpha1; of the 1-DOF block: mass = alpha1,
// damping = eta1, stiffness of its own. Those of the laws and of the effects follow, in the order of the files, and after
// these the values of each table at its knots.
enum Slot : int { alpha1, alpha2, beta3, eta1, eta12, coupling, stiffness, belt_speed, rig_slot_count };
inline constexpr std::array<std::string_view, rig_slot_count> rig_names{
    "alpha1", "alpha2", "beta3", "eta1", "eta12", "coupling", "stiffness", "belt_speed"};

constexpr int law_first = rig_slot_count;
constexpr int effect_first = law_first + stickslip::numbers_before<void>(stickslip::Laws{});
constexpr int slot_count = effect_first + stickslip::numbers_before<void>(stickslip::Effects{});
constexpr int parameter_count = slot_count + table_count * max_knots;
static_assert(stickslip::Effects::size <= 32, "an effect is a bit of Structure::effects");

// The state: x1 x2 y1 y2, then the hidden ones.
constexpr int visible_count = 4;
constexpr int hidden_count = stickslip::hidden_in(stickslip::Effects{});
constexpr int state_count = visible_count + hidden_count;

struct Structure {
  RigKind rig = RigKind::two_degree;
  int law = 0;                // place among the laws
  std::uint32_t effects = 0;  // bit k: the effect at place k
  Table table[table_count];   // the values at the knots are the slots after slot_count
};

}  // namespace stickslip_abi

namespace stickslip::inline STICKSLIP_ISA {

// Where the numbers of a law or an effect begin, which bit an effect is, and where its state stands.
template <class Owner>
constexpr int first_slot = contains<Owner>(Laws{}) ? stickslip_abi::law_first + numbers_before<Owner>(Laws{})
                                                   : stickslip_abi::effect_first + numbers_before<Owner>(Effects{});
template <class E>
constexpr std::uint32_t bit_of = std::uint32_t{1} << index_in<E>(Effects{});
template <class E>
constexpr int state_of = stickslip_abi::visible_count + E::hidden.place;

}  // namespace stickslip::inline STICKSLIP_ISA
