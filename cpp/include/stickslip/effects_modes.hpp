// Mode changes of a piece with effects.
#pragma once

#include "stickslip/effects_watch.hpp"
#include "stickslip/turn.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// The contact has changed: effects are told what it was before.
template <class T>
void leave_rest(const System<T>& sys, State<T>& s, Mode& mode, Side* on, Piece<T>& piece, int before) {
  if (mode.contact != 0) on[watch_contact] = Side::lower;
  each_turn(sys, s, mode, on, piece, [&](const auto& turn) {
    using E = typename std::decay_t<decltype(turn)>::Effect;
    if constexpr (requires { &E::template changes<T>; }) E::changes(turn, before);
  });
}

inline constexpr int first_moves = 4;  // derivatives of v that say where a block on bristles goes

// The contact mode of a block at rest on the belt, from its margins (or, on bristles, from where v goes).
template <class T>
void settle_at_rest(const System<T>& sys, State<T>& s, Mode& mode, Side* on, Piece<T>& piece) {
  const int before = mode.contact;
  mode.saturated = false;
  for (int i = 0; i < visible_count; ++i) state_series(piece, i)[0] = s.z[i];
  if (acts(sys, yields)) {
    mode.contact = 1;
    expand_effects(sys, mode, s, first_moves, piece);
    int k = 1;  // riding the belt with its spring relaxed, it leaves by a higher derivative than the first
    while (k < first_moves && value(piece.fx.v[k]) == 0) ++k;
    mode.contact = value(piece.fx.v[k]) < 0 ? -1 : 1;
  } else {
    mode.contact = 0;
    if (before != 0)  // it has just come to rest; a run may begin in a rest that has lasted
      each_turn(sys, s, mode, on, piece, [](const auto& turn) {
        using E = typename std::decay_t<decltype(turn)>::Effect;
        if constexpr (requires { &E::template halts<T>; }) E::halts(turn);
      });
    expand_effects(sys, mode, s, 0, piece);
    s.z[1] = piece.s.x2[0];
    Side stands = Side::none;
    mode.contact = contact_at_rest(plain(T(piece.fx.limit_minus[0] + piece.fx.friction[0])),
                                   plain(T(piece.fx.limit_plus[0] - piece.fx.friction[0])),
                                   plain(T(piece.fx.limit_minus[0] + piece.fx.limit_plus[0])), stands);
    if (stands == Side::upper) on[watch_contact] = Side::lower;  // the margins are watched from below
    if (stands == Side::lower) on[watch_demand] = Side::lower;
  }
  leave_rest(sys, s, mode, on, piece, before);
}

template <class T>
void change_effects(const System<T>& sys, State<T>& s, Mode& mode, Side* on, int id, Side side, Piece<T>& piece) {
  if (id == watch_kink) {
    mode.saturated = !mode.saturated;
    on[id] = opposite(side);
  } else if (id < effect_watches) {
    if (mode.contact != 0) return settle_at_rest(sys, s, mode, on, piece);
    mode.contact = id == watch_contact ? -1 : 1;
    mode.saturated = false;
    leave_rest(sys, s, mode, on, piece, 0);
  } else {
    each_turn(sys, s, mode, on, piece, [&](const auto& turn) {
      using E = typename std::decay_t<decltype(turn)>::Effect;
      if constexpr (HasSurface<E>) {
        if (id != effect_watch<E>) return;
        if constexpr (requires { E::cross(turn, side); }) {
          E::cross(turn, side);
        } else {
          turn.step(side);
        }
      }
    });
  }
}

// The side of every surface where a run starts; the contact is not known yet.
template <class T>
void set_effect_modes(const System<T>& sys, State<T>& s, Mode& mode, Side* on, Piece<T>& piece) {
  begin_series(s, piece);
  belt_next(sys, mode, s, piece, 0);
  piece.fx.v[0] = s.z[1] - piece.fx.belt[0];
  each_turn(sys, s, mode, on, piece, [](const auto& turn) {
    using E = typename std::decay_t<decltype(turn)>::Effect;
    if constexpr (requires { &E::template start<T>; }) E::start(turn);
  });
  each_turn(sys, s, mode, on, piece, [](const auto& turn) {
    using E = typename std::decay_t<decltype(turn)>::Effect;
    if constexpr (requires { &E::template start_by_force<T>; }) E::start_by_force(turn);
  });
}

}  // namespace stickslip::inline STICKSLIP_ISA
