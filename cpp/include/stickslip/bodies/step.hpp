// How long a step of a rig of bodies may be.
#pragma once

#include "stickslip/bodies/expand.hpp"
#include "stickslip/step.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr double own_scale_floor = 1e-3;  // a coordinate's scale beside the largest, by energy

// Is anything in the present modes no polynomial, no flow of a constant matrix: is its series cut by the tolerance?
template <class T>
struct Curves {
  bool motion = false, others = false;
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
  return out;
}

// For surfaces at which the force is continuous, what is left out moves the motion by its square.
constexpr double surface_share = 0.01;
inline double surface_tolerance(double rtol) { return surface_share * std::sqrt(rtol); }
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

// The step that keeps the last two terms of a series within `scale`.
template <class T>
Real<T> step_of(const T* c, const Real<T>& scale, int order, double rtol, double atol) {
  return step_from<T>(magnitude(value(c[order])), magnitude(value(c[order - 1])), scale, order, rtol, atol);
}

// Functions whose nearest singularity hides from the last terms when it is far off: tanh, asinh; and exponentials that
// are next to nothing but grow. `height` of an exponential is what it weighs beside the allowed.
template <class T>
Real<T> hidden_step(const Instruction<T>* list, int count, int order, Real<T> h, double height) {
  for (int i = 0; i < count; ++i) {
    const Instruction<T>& in = list[i];
    const bool root = in.code == Code::asinh, tanh = in.code == Code::tanh, grows = in.code == Code::exponential;
    if (!root && !tanh && !grows) continue;
    const double start = static_cast<double>(value(in.a[0]));
    const double by = grows ? std::abs(static_cast<double>(value(in.x))) : 1.0;
    const auto moves = [&](double step) {
      double x = 0;
      for (int k = order; k >= 1; --k) x = (x + std::abs(static_cast<double>(value(in.a[k])))) * step;
      return x * by;
    };
    const double reach = tanh ? 2.467 : 1.0;  // (pi/2)^2, 1: the square of how far it is beside the real axis
    const double own = static_cast<double>(value(in.c[0]));
    if (grows && own * own * height > 1) continue;  // seen
    h = shortened(h, [&](int, double step) {
      const double x = moves(step);
      if (!grows) return x <= 0.3 * std::sqrt(start * start + reach);
      const double grown = x < order ? order * std::log(x + 1e-300) - std::lgamma(order + 1.0) : x;
      return grown + std::log(own * height + 1e-300) <= 0;
    });
  }
  return h;
}

// Calls f(tape) for the formulas in use of every contact.
template <class T, class F>
void each_tape_in_use(const BodiesSystem<T>& sys, F&& f) {
  for (int j = 0; j < sys.contacts; ++j)
    for (int s = 0; s < 2; ++s)
      if (sys.contact[j].mode == sticks || s == (sys.contact[j].mode > 0)) f(sys.contact[j].tape[s]);
}

// Shortens a step for the derivatives by exponents. Where a^p is a polynomial, p being whole, its own terms do not show how
// near a = 0 is, but those of its derivative by p do: a^p log a. `share` is what friction pulls with over the allowed.
template <class T>
Real<T> step_by_exponents(const BodiesSystem<T>& sys, double share, int order, Real<T> h) {
  each_tape_in_use(sys, [&](const Tape<T>& tape) {
    for (int n = 0; n < tape.inners; ++n) {
      const Instruction<T>& in = tape.inner[n];
      if (in.code != Code::power || is_plain(in.x) || !(value(in.a[0]) > 0)) continue;
      double log[series_size], term[series_size];
      const auto plain = [](const T& x) { return static_cast<double>(value(x)); };
      for (int k = 0; k <= order; ++k) {
        double sum = 0;
        for (int j = 1; j < k; ++j) sum += j * log[j] * plain(in.a[k - j]);
        log[k] = k == 0 ? std::log(plain(in.a[0])) : (plain(in.a[k]) - sum / k) / plain(in.a[0]);
        term[k] = 0;
        for (int j = 0; j <= k; ++j) term[k] += log[j] * plain(in.c[k - j]);
      }
      h = shortened(h, [&](int, double step) {
        const double last = std::abs(term[order]) * step, before = std::abs(term[order - 1]);
        return std::max(last, before) * std::pow(step, order) * share <= tolerance_share;
      });
    }
  });
  return h;
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
      h = hidden_step(tape.inner, tape.inners, order, h, height);
      const int top = watched_order(sys, j, tape, order);
      h = hidden_step(tape.outer, tape.outers, top, h, height);
      const double near = c.mode == sticks || tape.jumps ? rtol : std::max(rtol, surface_tolerance(rtol));
      for (int i = 0; i < tape.surface_count; ++i) {
        const Node& one = tape.at(tape.surfaces[i]);
        const R scale =
            largest(R(magnitude(tape.node[one.a].now)), R(magnitude(tape.node[is_binary(one.op) ? one.b : one.a].now)));
        h = smallest(h, step_of(tape.surface_series + i * series_size, scale, top, near, atol));
      }
      if (c.mode == sticks && tape.outers > 0) {
        const T* limit = sys.margin + (2 * j + s) * series_size;
        const R scale = magnitude(value(limit[0])) + magnitude(value(sys.friction[j * series_size]));
        h = smallest(h, step_of(limit, scale, order, rtol, atol));
      }
    }
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
