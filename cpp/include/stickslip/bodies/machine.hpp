// The mode machine of a rig of bodies: expand, step, watch, land, change modes, go on.
#pragma once

#include "stickslip/bodies/corners.hpp"
#include "stickslip/bodies/derivative_step.hpp"
#include "stickslip/bodies/long_stretch.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
struct BodiesMachine {
  using R = Real<T>;
  BodiesSystem<T>& sys;
  Options opt;
  BodiesState<T> s{};
  Side *on = nullptr, *next_on = nullptr;
  Watch<T>* watch = nullptr;
  signed char *before = nullptr, *partner = nullptr;
  T* landed = nullptr;
  bool linear = false;  // the present piece, and all that may end it
  Summary summary;
  Chatter<R> chatter;
  long calm = 0;  // as of a named rig (trajectory.hpp); so is `asked`. From `seen_from` on every step is wanted
  R asked = R(std::numeric_limits<double>::infinity()), seen_from = asked;
  BodiesStretch<T> stretch;

  BodiesMachine(BodiesSystem<T>& system, const Options& options) : sys(system), opt(options) {
    sys.surface_order = std::min(surface_order_for(opt.rtol > 0 ? opt.rtol : opt.atol), opt.order);
  }
  void place(Arena& arena) {
    on = arena.take<Side>(sys.ids);
    next_on = arena.take<Side>(sys.ids);
    watch = arena.take<Watch<T>>(sys.ids);
    before = arena.take<signed char>(sys.contacts);
    partner = arena.take<signed char>(sys.contacts);
    landed = arena.take<T>(sys.at.state);
    s.z = arena.take<T>(sys.at.state);
    stretch.place(arena, sys.n, sys.contacts);
  }

  // Take the state from the system's values, and the modes given or (2) found from it.
  void start(double t, const signed char* modes) {
    s.t = T(t);
    for (int i = 0; i < sys.at.state; ++i) s.z[i] = sys.values[sys.at.initial + i];
    for (int i = 0; i < sys.ids; ++i) on[i] = Side::none;
    for (int j = 0; j < sys.contacts; ++j) sys.contact[j].since = s.t - sys.values[sys.at.dwell + j];
    for (int i = 0; i < sys.speeds; ++i) sys.rail[i].now = piece_at(sys, i, t);
    set_bodies_modes(sys, s, modes, true, on);
  }

  template <class Observe, class Changed, class Stepped, class Stop>
  void run(Observe&& observe, Changed&& changed, Stepped&& stepped, Stop&& stop) {
    const R pace = largest(R(largest(sys.frequency, sys.rate)), R(1.0 / (opt.t_end - value(s.t) + 1e-300)));
    while (value(s.t) < opt.t_end) {
      if (summary.steps >= opt.max_steps) return finish(Outcome::too_many_steps);
      if ((++summary.steps & 1023) == 0 && stop()) return finish(Outcome::interrupted);
      const R ahead = smallest(R(opt.t_end), next_corner(sys)), left = ahead - value(s.t);
      R h(0.0);
      const int order = expand(h, left > 0 ? left : R(std::numeric_limits<double>::min()));
      if (!(h > 0)) return finish(Outcome::not_finite);
      if (!(left > 0)) {  // an event came at the very time of a corner
        advance(T(ahead) - s.t, order);
        if (!goes_over([&] { turn_corners(sys, s, ahead, on); }, changed)) return;
        continue;
      }
      if (linear && value(s.t) < seen_from && ++calm > patience && crosses(h, left, observe, stepped)) continue;
      const bool last = h >= left;
      if (last) h = left;
      const R least = std::numeric_limits<R>::epsilon() * magnitude(value(s.t));
      if (!(h > least) && !last) return finish(Outcome::step_too_small);
      const int watches = list_watches(sys, watch);
      const Exit<T> exit = first_exit(watch, watches, order, h, on, opt.henon);
      T dt(h);
      if (exit.found) {
        const Watch<T>& w = watch[exit.watch];
        const T& bound = exit.side == Side::lower ? w.lo : w.hi;
        // what a jump has put beyond a bound is beyond it at that time, wherever the bound is
        dt = exit.t > 0 || !far_beyond(w, bound, R(1.0 / pace)) ? with_derivatives(w.c, bound, order, exit.t) : T(0.0);
        h = exit.t;
      } else if (last) {
        dt = T(ahead) - s.t;
      }
      const bool ends = last && !exit.found && ahead >= opt.t_end;
      observe(*this, h, order, ends);
      const int met = exit.found ? watch[exit.watch].id : -1;
      find_partners(sys, met, order, h, partner);
      advance(dt, order);
      if (!std::isfinite(sum_of(sys, s))) return finish(Outcome::not_finite);
      if (h > 2 * least) {  // after no time it stands where it stood
        leave_surfaces(sys, watch, watches, order, h, met, on, next_on);
      } else if (met >= 0) {
        on[met] = Side::none;
      }
      const bool corner = last && !exit.found && !ends;
      if (exit.found || corner) {
        const bool goes_on = goes_over(
            [&] {
              if (corner) {
                turn_corners(sys, s, ahead, on);
              } else if (is_kink(sys, watch[exit.watch], exit.side)) {
                change_pieces(sys, s, exit, watch, watches, order, on);
              } else {
                change_contact(sys, s, met, partner, on);
                if (sys.pushes > 0) face_surfaces(sys, s, watch, R(1.0 / pace), on);
              }
            },
            changed);
        if (!goes_on) return;
        if (!corner && chatter.sees(value(s.t), pace)) return finish(Outcome::chatter);
      }
      stepped(*this);
      if (ends) break;
    }
    finish(Outcome::finished);
  }

  void state_at(const T& h, int order, T* z) const { bodies_state(sys, h, order, z); }

 private:
  template <class Observe, class Stepped>
  bool crosses(const R& unit, const R& left, Observe& observe, Stepped& stepped) {
    const R h = cross(sys, stretch, unit, smallest(left, R(smallest(asked, seen_from) - value(s.t))), s);
    if (!(h > 0)) {
      calm = patience / 2;
      return false;
    }
    observe(*this, h, 0, false);
    for (int i = 0; i < sys.ids; ++i) on[i] = Side::none;
    stepped(*this);
    return true;
  }
  // Modes or pieces change; false where that is one change too many.
  template <class Change, class Changed>
  bool goes_over(Change&& change, Changed& told) {
    calm = 0;
    for (int j = 0; j < sys.contacts; ++j) before[j] = sys.contact[j].mode;
    change();
    bool kink = true;
    for (int j = 0; j < sys.contacts; ++j) kink = kink && before[j] == sys.contact[j].mode;
    ++(kink ? summary.kinks : summary.transitions);
    told(*this, kink);
    if (summary.transitions + summary.kinks < opt.max_transitions) return true;
    finish(Outcome::too_many_transitions);
    return false;
  }
  // The series of the piece that starts here; returns their order, and the step in h.
  int expand(R& h, const R& left) {
    set_first(sys, s);
    const Curves<T> curves = curves_of(sys);
    linear = !curves.motion && !curves.others && sys.pushes == 0;
    const bool polynomial = !curves.motion && !curves.others && sys.stuck_count == sys.n;
    const int order = polynomial ? polynomial_order : (curves.motion ? opt.order : linear_order);
    expand_bodies(sys, order);
    if (curves.motion && starts_at_zero(sys)) {
      h = R(expand_at_zero(sys, order, opt.rtol, opt.atol, static_cast<double>(left)));
      return order;
    }
    h = polynomial ? left : step_with_derivatives(sys, curves, order, opt.rtol, opt.atol, left);
    return order;
  }

  void advance(const T& dt, int order) {
    state_at(dt, order, landed);
    for (int i = 0; i < sys.at.state; ++i) s.z[i] = landed[i];
    s.t = s.t + dt;
  }
  void finish(Outcome outcome) {
    summary.outcome = outcome;
    summary.t = static_cast<double>(value(s.t));
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
