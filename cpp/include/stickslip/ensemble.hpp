// Many trajectories: lanes binned by mode, refilled from a queue, observed on the fly.
//
// Binning beats masks because a batch runs one piece's recurrences only. A lane leaves its batch when its mode
// changes and waits in the bin of its new mode; the fullest bin runs next, so that hardly a lane idles.
#pragma once

#include "stickslip/alone.hpp"
#include "stickslip/landing_queue.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <int W>
struct Ensemble {
  const SweepRequest& q;
  int order;
  Batch<W> batch[bin_count];
  Member pool[pool_size<W>];
  Batch<W> lander;
  Line<W> waiting;
  Line<W> landing;  // members that may meet a surface in the step from where they are
  Common common;
  Piece<double> scratch;
  Company company;

  explicit Ensemble(const SweepRequest& request)
      : q(request), order(order_for(tolerance_share * (request.rtol > 0 ? request.rtol : request.atol))) {}

  void run() {
    prepare(q, common);
    for (Batch<W>& b : batch) b.one_law = common.law;
    lander.one_law = common.law;
    for (Member& m : pool) next(m);
    for (;;) {
      const int b = fullest(), due = landing.longest();
      if (due >= 0 && (landing.length[due] >= W || b < 0 || load_of(b) < W)) {
        land_deferred(due);
      } else if (b >= 0) {
        refill(b);
        do {
          step(batch[b], false);
          refill(b);
        } while (landing.length[b] < W && (batch[b].active == W || (batch[b].active > 0 && load_of(b) >= others(b))));
      } else {
        return;
      }
    }
  }

 private:
  int load_of(int b) const { return batch[b].active + waiting.length[b]; }
  int fullest() const {
    int best = 0;
    for (int b = 1; b < bin_count; ++b)
      if (load_of(b) > load_of(best)) best = b;
    return load_of(best) > 0 ? best : -1;
  }
  void land_deferred(int b) {
    for (int i = 0; i < W && landing.length[b] > 0; ++i) enter(lander, i, landing.take(b));
    step(lander, true);
  }
  int others(int b) const {
    int most = 0;
    for (int k = 0; k < bin_count; ++k)
      if (k != b && load_of(k) > most) most = load_of(k);
    return most;
  }
  void refill(int b) {
    for (int i = 0; i < W && waiting.length[b] > 0; ++i)
      if (batch[b].member[i] == nullptr) enter(batch[b], i, waiting.take(b));
  }
  // Takes the next member. Lanes share the shape of their branches; one whose curve starts below its floor goes alone.
  void next(Member& m) {
    for (m.index = q.take(q.context); m.index >= 0; m.index = q.take(q.context)) {
      start_member(q, common, m, scratch);
      if (company.takes(m)) return waiting.add(m);
      run_alone(q, m);
    }
  }

  // One step of all lanes. Lanes that may meet a surface are landed here if they are many, or if the batch is there `to_land`;
  // else they leave as they are, until there is a register full of them.
  void step(Batch<W>& b, bool to_land) {
    using L = Lanes<W>;
    if (b.active == 0) return;
    const int busy = __builtin_ctz(b.busy);
    if (b.active < W) fill_idle(b, busy);
    L h;
    for (int k = 0; k < 4; ++k) state_series(b.piece, k)[0] = b.s.z[k];
    const int p = expand_plain(b.sys, b.mode, order, b.piece, h);
    const bool linear = h[busy] != 0;
    if (!linear) h = step_plain(b.sys, b.piece.s, p, q.rtol, q.atol);
    h = min(h, b.limit - b.s.t);
    const Watch<L>& watch = b.piece.watch[0];
    Side through[W];
    unsigned events = 0;
    const L rest = tail(watch.c, p, h);
    const unsigned lower = watch.has_lo ? suspects(b, watch, Side::lower, h, rest) : 0;
    const unsigned upper = watch.has_hi ? suspects(b, watch, Side::upper, h, rest) : 0;
    if (lower | upper) {
      if (to_land || 2 * __builtin_popcount(lower | upper) >= W) {
        land_first(b, watch, lower, upper, p, h, through, events);
      } else {
        for (unsigned left = lower | upper; left != 0; left &= left - 1) defer(b, __builtin_ctz(left), landing);
        if (b.busy == 0) return;
      }
    }
    if ((q.observe & (ob_range | ob_dissipated)) != 0) observe(q, b, p, h);
    evaluate_four<L>({b.piece.s.x1, b.piece.s.x2, b.piece.s.y1, b.piece.s.y2}, p, h, b.s.z);
    if (b.mode.contact == 0) b.s.z[1] = b.sys.rig.v_b;
    b.s.t = b.s.t + h;
    if (linear && events == 0 && ++b.turns % patience == 0) cross_long(q, b, h);
    finish_step(b, h, events, through, to_land);
  }

  void finish_step(Batch<W>& b, const Lanes<W>& h, unsigned events, const Side* through, bool all) {
    b.steps += Lanes<W>(1.0);
    if (b.mode.contact == 0) b.stick += h;
    leave_surfaces(b, h);
    const unsigned going =
        mask_of<W>((b.s.t.v < b.limit.v) & (h.v > 0) & (b.steps.v < static_cast<double>(q.max_steps)));
    for (unsigned left = (all ? b.busy : events | ~going) & b.busy; left != 0; left &= left - 1) {
      const int i = __builtin_ctz(left);
      Member* m = b.member[i];
      m->on[watch_contact] = side_of(b, i);
      leave(b, i);
      Outcome outcome = Outcome::finished;
      if ((events >> i & 1u) != 0) outcome = change(q, *m, watch_contact, through[i], scratch);
      goes_on(q, *m, outcome) ? waiting.add(*m) : done(*m, outcome);
    }
  }

  void done(Member& m, Outcome outcome) {
    report(q, m, outcome);
    next(m);
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
