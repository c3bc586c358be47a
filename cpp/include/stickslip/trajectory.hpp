// The mode machine: expand a piece, step, watch its switching functions, land, change mode, go on.
#pragma once

#include "stickslip/chatter.hpp"
#include "stickslip/derivative_step.hpp"
#include "stickslip/long_stretch.hpp"
#include "stickslip/options.hpp"
#include "stickslip/start.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
struct Machine {
  using R = Real<T>;
  const System<T>& sys;
  Options opt;
  State<T> s;
  Mode mode;
  Piece<T> piece;
  Side on[watch_count] = {};
  Summary summary;
  Chatter<R> chatter;
  long calm = 0;                                         // steps of a linear mode since it began or was crossed in vain
  R asked = R(std::numeric_limits<double>::infinity());  // time at which the observer wants to look next
  bool sees_slips = false;                               // the observer wants every step of a slip
  [[no_unique_address]] decltype(change_by_seed(std::declval<const System<T>&>())) change;

  Machine(const System<T>& system, const Options& options)
      : sys(system), opt(options), change(change_by_seed(system)) {}

  // Take the state and find (contact = 2) or take the mode to start in.
  void start(const State<T>& state, int contact) {
    s = state;
    mode = Mode{};
    set_modes(sys, s, mode, on, contact, piece);
  }

  // `observe(machine, h, order, last)` sees each step before the state moves on, `stepped(machine)` after; a stretch that is
  // crossed at once has order 0, and no time at which anything is asked.
  // `changed(machine, before, kink)` sees each transition; `stop()` is asked now and then.
  template <class Observe, class Changed, class Stepped, class Stop>
  void run(Observe&& observe, Changed&& changed, Stepped&& stepped, Stop&& stop) {
    while (value(s.t) < opt.t_end) {
      if (summary.steps >= opt.max_steps) return finish(Outcome::too_many_steps);
      if ((++summary.steps & 1023) == 0 && stop()) return finish(Outcome::interrupted);
      R h(0.0);
      const int order = expand(sys, mode, s, opt.order, piece, h);
      const R left = R(opt.t_end) - value(s.t);
      if (h > 0 && ++calm > patience && opt.fixed_step == 0 && crosses(h, left, observe, stepped)) continue;
      if (opt.fixed_step > 0) h = R(opt.fixed_step);
      if (h == 0) {
        h = step_length(sys, mode, s, piece, order, opt.rtol, opt.atol);
        if constexpr (requires(T x) { x.d[0]; })
          h = derivative_step(sys, change, mode, s, piece, order, h, opt.rtol > 0 ? opt.rtol : opt.atol);
      }
      settle_step(sys, mode, s, piece, order, h, opt.rtol, opt.atol);
      if (!(h > 0)) return finish(Outcome::not_finite);
      const bool last = h >= left;
      if (last) h = left;
      const R least = std::numeric_limits<R>::epsilon() * magnitude(value(s.t));
      if (!(h > least) && !last) return finish(Outcome::step_too_small);
      const Exit<T> exit = first_exit(piece.watch, piece.watches, order, h, on, opt.henon);
      T dt(h);
      if (exit.found) {
        const Watch<T>& w = piece.watch[exit.watch];
        dt = hardly_moves(sys, piece, w, order, exit.t)
                 ? T(exit.t)
                 : with_derivatives(w.c, exit.side == Side::lower ? w.lo : w.hi, order, exit.t);
        h = exit.t;
      } else if (last) {
        dt = T(R(opt.t_end)) - s.t;
      }
      observe(*this, h, order, last && !exit.found);
      advance(dt, order);
      if (!finite()) return finish(Outcome::not_finite);
      leave_surfaces(h, order, exit.found ? piece.watch[exit.watch].id : watch_count);
      if (exit.found) {
        const Mode before = mode;
        calm = 0;
        change_mode(sys, s, mode, on, piece.watch[exit.watch].id, exit.side, piece);
        const bool kink = before.contact == mode.contact;
        ++(kink ? summary.kinks : summary.transitions);
        changed(*this, before, kink);
        if (chatter.sees(value(s.t), natural_frequency(sys))) return finish(Outcome::chatter);
        if (summary.transitions + summary.kinks >= opt.max_transitions) return finish(Outcome::too_many_transitions);
      }
      stepped(*this);
      if (last && !exit.found) break;
    }
    finish(Outcome::finished);
  }

  // The state `h` after the start of the piece, those of the bits `plain` without derivatives.
  void state_at(const T& h, int order, T* z, std::uint32_t plain = 0) {
    piece_state(sys, mode, piece, s, order, h, z, plain);
  }

 private:
  template <class Observe, class Stepped>
  bool crosses(const R& unit, const R& left, Observe& observe, Stepped& stepped) {
    State<T> next = s;
    const bool may = mode.contact == 0 || !sees_slips;
    const R h = may ? cross(sys, mode, piece.watch[0], unit, smallest(left, R(asked - value(s.t))), next) : R(0.0);
    if (!(h > 0)) {
      calm = patience / 2;
      return false;
    }
    observe(*this, h, 0, false);
    s = next;
    on[watch_contact] = Side::none;
    stepped(*this);
    return true;
  }
  void advance(const T& dt, int order) {
    T z[state_count];
    state_at(dt, order, z);
    for (int i = 0; i < state_count; ++i) s.z[i] = z[i];
    s.t = s.t + dt;
  }
  bool finite() const {
    R sum = value(s.t);
    for (int i = 0; i < state_count; ++i) sum += value(s.z[i]);
    return std::isfinite(sum);
  }
  // A step on, it stands on no surface any more, unless it has not moved away from it; not on the one that it `met`.
  void leave_surfaces(const R& h, int order, int met) {
    Side next[watch_count] = {};
    for (int w = 0; w < piece.watches; ++w) {
      const int id = piece.watch[w].id;
      if (id != met && still_on(piece.watch[w], on[id], order, h)) next[id] = on[id];
    }
    for (int id = 0; id < watch_count; ++id) on[id] = next[id];
  }
  void finish(Outcome outcome) {
    summary.outcome = outcome;
    summary.t = static_cast<double>(value(s.t));
    summary.contact = mode.contact;
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
