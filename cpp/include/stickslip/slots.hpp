// The public names of the slots and states of structure.hpp, in their order, and the way back from a name.
#pragma once

#include "stickslip/structure.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// A number of a law or an effect has the name of its owner before its own: "paper.A1", "belt_seam.a".
struct SlotName {
  std::string_view owner, own;
  constexpr bool operator==(std::string_view full) const {
    if (owner.empty()) return full == own;
    return full.size() == owner.size() + 1 + own.size() && full.starts_with(owner) && full[owner.size()] == '.' &&
           full.ends_with(own);
  }
};

consteval auto all_slots() {
  std::array<SlotName, stickslip_abi::slot_count> out;
  std::size_t at = 0;
  for (const auto& name : stickslip_abi::rig_names) out[at++] = {"", name};
  const auto put = [&]<class... All>(TypeList<All...>, const auto& owners) {
    std::size_t owner = 0;
    const auto one = [&](const auto& own) {
      for (const auto& name : own) out[at++] = {owners[owner], name};
      ++owner;
    };
    (one(All::parameters), ...);
  };
  put(Laws{}, law_names);
  put(Effects{}, effect_names);
  return out;
}
inline constexpr auto slot_names = all_slots();

void two_hidden_states_at_one_place();  // does not compile where it is called: it is none of a constant
consteval auto all_states() {
  std::array<std::string_view, stickslip_abi::state_count> out{"x1", "x2", "y1", "y2"};
  const auto one = [&]<class E> {
    if constexpr (requires { E::hidden; }) out[static_cast<std::size_t>(state_of<E>)] = E::hidden.name;
  };
  [&]<class... E>(TypeList<E...>) { (one.template operator()<E>(), ...); }(Effects{});
  for (const auto& name : out)
    if (name.empty()) two_hidden_states_at_one_place();
  return out;
}
inline constexpr auto state_names = all_states();

consteval stickslip_abi::Slot slot(std::string_view name) {
  return static_cast<stickslip_abi::Slot>(place_of(slot_names, name));
}
consteval int law(std::string_view name) { return place_of(law_names, name); }
consteval int state(std::string_view name) { return place_of(state_names, name); }
consteval std::uint32_t effect(std::string_view name) { return std::uint32_t{1} << place_of(effect_names, name); }

}  // namespace stickslip::inline STICKSLIP_ISA
