// How long a step of a rig of bodies may be.
#pragma once

#include "stickslip/bodies/expand.hpp"
#include "stickslip/bodies/exponents.hpp"
#include "stickslip/bodies/tape_step.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr double own_scale_floor = 1e-3;  // a coordinate's scale beside the largest, by energy

// Is anything in the present modes no polynomial, no flow of a constant matrix: is its series cut by the tolerance?
template <class T>
struct Curves {
  bool motion = false, others = false, pushes = false;  // pushes: what holds a stuck contact too
};
template <class T>
Curves<T> curves_of(const BodiesSystem<T>& sys) {
  Curves<T> out;
  for (int s = 0; s < sys.speeds; ++s) out.motion = out.motion || !sys.rail[s].linear;
  for (int j = 0; j < sys.contacts; ++j) {
    const Contact<T>& c = sys.contact[j];
    out.motion = out.motion || !c.linear;
    for (int s = 0; s < 2; ++s)
      if (c.mode == sticks || s == (c.mode > 0)) out.others = out.others || c.tape[s].outers > 0 || c.states > 0;
  }
  for (int e = 0; e < sys.pushes; ++e) {
    const Push<T>& p = sys.push[e];
    out.pushes = out.pushes || !p.steady;
    out.others = out.others || p.tape.outers > 0 || p.states > 0;
  }
  out.motion = out.motion || out.pushes;
  return out;
}

constexpr int surface_orders = 5;  // more than Jorba and Zou's: fewer steps of a formula that saturates, by a third

// What is allowed of each coordinate's speed in one step: the tolerance of its own motion.
template <class T>
void allowed_speeds(const BodiesSystem<T>& sys, double rtol, double atol, Real<T>* allowed) {
  using R = Real<T>;
  R top(0.0);
  for (int i = 0; i < sys.n; ++i) {
    const R speed = magnitude(value(sys.v[i * series_size])), place = magnitude(value(sys.q[i * series_size]));
    allowed[i] = largest(speed, R(place * sys.frequency));
    top = largest(top, R(allowed[i] * sys.weight[i]));
  }
  for (int i = 0; i < sys.n; ++i)
    allowed[i] = R(atol) + R(rtol) * largest(allowed[i], R(top * own_scale_floor / sys.weight[i]));
}

template <class T>
Real<T> step_of_bodies(const BodiesSystem<T>& sys, const Curves<T>& curves, int order, double rtol, double atol,
                       const Real<T>& left) {
  using R = Real<T>;
  R h = left;
  if (!curves.motion && sys.rate * left > linear_reach) h = R(linear_reach) / sys.rate;
  if (curves.motion) {
    R allowed[64], last(0.0), before(0.0);
    allowed_speeds(sys, rtol, atol, allowed);
    for (int i = 0; i < sys.n; ++i) {
      last = largest(last, R(magnitude(value(sys.v[i * series_size + order])) / allowed[i]));
      before = largest(before, R(magnitude(value(sys.v[i * series_size + order - 1])) / allowed[i]));
    }
    h = smallest(h, step_from<T>(last, before, R(1.0), order, 1.0, 0.0));
    double share = 0;
    for (int i = 0; i < sys.n; ++i)
      for (int j = 0; j < sys.contacts; ++j) {
        const double pull = static_cast<double>(value(sys.reach[j * sys.n + i]) * value(sys.force[j * series_size]));
        share = std::max(share, std::abs(pull) / static_cast<double>(allowed[i]));
      }
    h = step_by_exponents(sys, share, order, h);
  }
  if (!curves.motion && !curves.others) return h;
  const double height = 1 / (tolerance_share * (rtol > 0 ? rtol : atol));
  for (int j = 0; j < sys.contacts; ++j) {
    const Contact<T>& c = sys.contact[j];
    for (int s = 0; s < 2; ++s) {
      if (c.mode != sticks && s != (c.mode > 0)) continue;
      const Tape<T>& tape = c.tape[s];
      const double near = c.mode == sticks || tape.jumps ? rtol : std::max(rtol, surface_tolerance(rtol));
      h = step_of_tape(tape, order, watched_order(sys, j, tape, order), near, atol, h, height);
      if (c.mode == sticks && (tape.outers > 0 || curves.pushes)) {
        const T* limit = sys.margin + (2 * j + s) * series_size;
        const R scale = magnitude(value(limit[0])) + magnitude(value(sys.friction[j * series_size]));
        h = smallest(h, step_of(limit, scale, order, rtol, atol));
      }
    }
  }
  for (int e = 0; e < sys.pushes; ++e) {
    const Tape<T>& tape = sys.push[e].tape;
    const double near = tape.jumps ? rtol : std::max(rtol, surface_tolerance(rtol));
    h = step_of_tape(tape, order, watched_order(sys, tape, order), near, atol, h, height);
  }
  for (int s = 0; s < sys.speeds; ++s) {
    const Tape<T>& tape = sys.rail[s].piece[sys.rail[s].now];
    h = hidden_step(tape.inner, tape.inners, order, h, height);
    if (!sys.rail[s].linear)
      h = smallest(h, step_of(sys.V + s * series_size, R(magnitude(value(sys.V[s * series_size]))), order, rtol, atol));
  }
  for (int i = 0; i < sys.states; ++i) {  // beside their own largest term
    const T* z = sys.z + i * series_size;
    h = shortened(h, [&](int, double step) {
      double term[series_size], power = 1, top = atol;
      for (int k = 0; k <= order; ++k, power *= step) {
        term[k] = std::abs(static_cast<double>(value(z[k]))) * power;
        if (k < order - 1) top = std::max(top, term[k]);
      }
      return !(std::max(term[order], term[order - 1]) > tolerance_share * (rtol > 0 ? rtol : atol) * top);
    });
  }
  return h;
}

}  // namespace stickslip::inline STICKSLIP_ISA
