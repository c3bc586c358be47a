// What is summed up of a run of a rig of bodies on its way: extremes of its state, work of friction.
#pragma once

#include <algorithm>

#include "stickslip/bodies/machine.hpp"
#include "stickslip/bodies/sensed.hpp"
#include "stickslip/over_step.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct BodiesTally {
  const stickslip_abi::BodiesTotals& asked;
  double *z = nullptr, *felt = nullptr;

  void place(Arena& arena, const BodiesSystem<double>& sys) {
    z = arena.take<double>(sys.at.state);
    felt = arena.take<double>(sensed_count(*sys.b));
  }
  bool any() const { return asked.low != nullptr || asked.work != nullptr; }
  void clear(const BodiesSystem<double>& sys) const {
    for (int i = 0; asked.low != nullptr && i < 2 * sys.n; ++i) {
      asked.low[i] = std::numeric_limits<double>::infinity();
      asked.high[i] = -asked.low[i];
    }
    for (int j = 0; asked.work != nullptr && j < sys.contacts; ++j) asked.work[j] = 0.0;
  }
  // A step of length h that begins where the machine is; the part of it from `after` on.
  void step(const BodiesMachine<double>& machine, double h, int order) const {
    const BodiesSystem<double>& sys = machine.sys;
    const double from = std::max(0.0, asked.after - machine.s.t);
    if (!any() || order == 0 || !(from < h)) return;
    for (int i = 0; asked.low != nullptr && i < 2 * sys.n; ++i) {
      const double* c = i < sys.n ? sys.q + i * series_size : sys.v + (i - sys.n) * series_size;
      widen(asked.low[i], asked.high[i], {c, 1}, order, from, h);
    }
    for (int j = 0; asked.work != nullptr && j < sys.contacts; ++j)
      if (sys.contact[j].mode != sticks)
        asked.work[j] += integral(from, h, [&](double t) { return power(machine, j, t, order); });
  }

 private:
  // T v of contact j, t after the start of the piece.
  double power(const BodiesMachine<double>& machine, int j, double t, int order) const {
    const BodiesSystem<double>& sys = machine.sys;
    machine.state_at(t, order, z);
    sense(sys, t, order, z, felt);
    const double *friction = felt + sys.n, *V = friction + sys.contacts + sys.pushes;
    const double v = dot(sys.D(j), z + sys.n, sys.n);
    const int speed = sys.contact[j].speed;
    return friction[j] * (speed < 0 ? v : v - V[speed]);
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
