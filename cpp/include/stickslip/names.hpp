// Lists of types, and numbers that are called by their names; the compiler looks the names up.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <type_traits>

#include "stickslip/isa.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class... E>
struct TypeList {
  static constexpr int size = sizeof...(E);
};

template <std::size_t N>
using Names = std::array<std::string_view, N>;

// Place of a name in a list; a name that is not there does not compile, for this function is none of a constant.
void no_such_name();
template <class Name, std::size_t N>
consteval int place_of(const std::array<Name, N>& all, std::string_view name) {
  for (std::size_t i = 0; i < N; ++i)
    if (all[i] == name) return static_cast<int>(i);
  no_such_name();
  return -1;
}

// Is E in a list? Its place there, and how many numbers those before it have; of one that is not in it, all have.
template <class E, class... All>
consteval bool contains(TypeList<All...>) {
  return (std::is_same_v<E, All> || ...);
}
template <class E, class... All>
consteval int index_in(TypeList<All...>) {
  int at = 0;
  bool found = false;
  ((found = found || std::is_same_v<E, All>, at += found ? 0 : 1), ...);
  return at;
}
template <class E, class... All>
consteval int numbers_before(TypeList<All...>) {
  int count = 0;
  bool found = false;
  ((found = found || std::is_same_v<E, All>, count += found ? 0 : static_cast<int>(All::parameters.size())), ...);
  return count;
}

// How many of those before E are such that has<E>(); of all if E is not in the list.
template <class E, class... All, class Has>
consteval int count_before(TypeList<All...>, const Has& has) {
  int count = 0;
  bool found = false;
  ((found = found || std::is_same_v<E, All>, count += !found && has.template operator()<All>() ? 1 : 0), ...);
  return count;
}

// How many have a hidden state.
template <class... All>
consteval int hidden_in(TypeList<All...>) {
  return ((requires { All::hidden; } ? 1 : 0) + ... + 0);
}

// A parameter of an effect or a law.
template <class Owner>
struct Key {
  int place;
  consteval Key(const char* name)  // NOLINT(google-explicit-constructor): p["tau"]
      : place(place_of(Owner::parameters, name)) {}
};

// The numbers of an effect or a law: p["tau"].
template <class Owner, class T>
struct Numbers {
  const T* first;
  const T& operator[](Key<Owner> key) const { return first[key.place]; }
};

}  // namespace stickslip::inline STICKSLIP_ISA
