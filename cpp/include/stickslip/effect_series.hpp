// Coefficients of a piece beyond the motion's own.
#pragma once

#include "stickslip/structure.hpp"

namespace stickslip::inline STICKSLIP_ISA {

using namespace stickslip_abi;  // NOLINT(google-build-using-namespace): plain data shared by every build

// The series of its own that an effect or the curve of a law has.
struct NoSeries {};
template <class E, class T>
struct SeriesOf {
  using type = NoSeries;
};
template <class E, class T>
  requires requires { typename E::template Series<T>; }
struct SeriesOf<E, T> {
  using type = typename E::template Series<T>;
};
template <class T, class List>
struct OwnSeries;
template <class T>
struct OwnSeries<T, TypeList<>> {};
template <class T, class E, class... Rest>
struct OwnSeries<T, TypeList<E, Rest...>> {
  [[no_unique_address]] typename SeriesOf<E, T>::type first;
  [[no_unique_address]] OwnSeries<T, TypeList<Rest...>> rest;
};
template <class Wanted, class T, class E, class... Rest>
auto& own_series(OwnSeries<T, TypeList<E, Rest...>>& all) {
  if constexpr (std::is_same_v<Wanted, E>) {
    return all.first;
  } else {
    return own_series<Wanted>(all.rest);
  }
}

// Effects that friction is multiplied by.
template <class E>
concept HasShare = requires { &E::template share<double>; };
constexpr int share_count = count_before<void>(Effects{}, []<class E> { return HasShare<E>; });
template <class E>
constexpr int share_of = count_before<E>(Effects{}, []<class Other> { return HasShare<Other>; });

// Coefficients of what effects bring along, one array a quantity; only those of active effects are ever touched.
template <class T>
struct EffectSeries {
  T hidden[hidden_count][series_size];
  T belt[series_size], v[series_size], u[series_size];  // V(t); v_w; what kinetic friction depends on
  T friction[series_size], magnitude[series_size], kinetic[series_size];
  T share[share_count][series_size], factor[share_count][series_size];
  T limit_minus[series_size], limit_plus[series_size], at_minus[series_size], at_plus[series_size];
  OwnSeries<T, Laws> law;
  OwnSeries<T, Effects> own;
};

}  // namespace stickslip::inline STICKSLIP_ISA
