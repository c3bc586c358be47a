// One member of a sweep by the scalar mode machine: models with effects, and what the lanes are compared with.
#pragma once

#include "stickslip/batch.hpp"
#include "stickslip/trajectory.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// A member that start_member() has set up, to its end.
inline void run_alone(const SweepRequest& q, Member& m) {
  const double tightest = q.rtol > 0 ? q.rtol : q.atol;
  Options options{q.rtol,     q.atol, q.t_end, true, order_for(tolerance_share * tightest), 0.0, q.max_transitions,
                  q.max_steps};
  Machine<double> machine(m.sys, options);
  machine.sees_slips = (q.observe & (ob_range | ob_dissipated)) != 0;
  machine.start(m.s, 2);
  bool counting = q.after <= 0;
  const auto observe = [&](Machine<double>& now, double h, int order, bool) {
    if (!counting) return;
    if (now.mode.contact == 0) m.tally.row.stick_time += h;
    if (order == 0) return;
    Strided z[4];
    for (int k = 0; k < 4; ++k) z[k] = {state_series(now.piece, k), 1};
    const bool plain = m.sys.structure.effects == 0;
    observe_step(m.tally, plain ? q.observe : q.observe & ~ob_dissipated, m.sys.rig, z, now.mode.contact, order, h);
    if (!plain && (q.observe & ob_dissipated) != 0 && now.mode.contact != 0)
      m.tally.row.dissipated += work({now.piece.fx.friction, 1}, {now.piece.fx.v, 1}, order - 1, h);
  };
  const auto changed = [&](Machine<double>& now, const Mode& before, bool kink) {
    if (counting && !kink) observe_transition(m.tally, q.points, before.contact, now.mode.contact, now.s.t, now.s.z);
  };
  const auto no = [] { return false; };
  const auto nothing = [](Machine<double>&) {};
  if (!counting) {
    machine.opt.t_end = q.after;
    machine.run(observe, changed, nothing, no);
    clear(m.tally);
    counting = true;
    machine.calm = 0;
    machine.opt.t_end = q.t_end;
  }
  if (machine.summary.outcome == Outcome::finished) machine.run(observe, changed, nothing, no);
  for (int i = 0; i < state_count; ++i) m.s.z[i] = machine.s.z[i];
  m.s.t = machine.s.t;
  m.tally.row.steps = static_cast<double>(machine.summary.steps);
  report(q, m, machine.summary.outcome);
}

}  // namespace stickslip::inline STICKSLIP_ISA
