// Many trajectories: lanes binned by mode, refilled from a queue, observed on the fly.
//
// Binning beats masks because a batch runs one piece's recurrences only. A lane leaves its batch when its mode
// changes and waits in the bin of its new mode; the fullest bin runs next, so that hardly a lane idles.
#pragma once

#include "stickslip/alone.hpp"
#include "stickslip/landing.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr int bin_count = 5;  // stick; either slip, curved or saturated

inline int bin_of(const Mode& mode) {
  if (mode.contact == 0) return 0;
  return (mode.contact < 0 ? 1 : 3) + (mode.saturated ? 1 : 0);
}

template <int W>
struct Ensemble {
  static constexpr int pool_size = 6 * W;
  const SweepRequest& q;
  int order;
  Batch<W> batch[bin_count];
  Member pool[pool_size];
  Batch<W> lander;
  Member* waiting[bin_count][pool_size];
  Member* landing[bin_count][pool_size];  // may meet a surface in the step from where they are
  int queued[bin_count] = {}, deferred[bin_count] = {};
  Common common;
  Piece<double> scratch;
  Branch<double> minus, plus;
  bool first = true;

  explicit Ensemble(const SweepRequest& request)
      : q(request), order(order_for(tolerance_share * (request.rtol > 0 ? request.rtol : request.atol))) {}

  void run() {
    prepare(q, common);
    for (Member& m : pool) next(m);
    for (;;) {
      const int b = fullest(), due = longest();
      if (due >= 0 && (deferred[due] >= W || b < 0 || load_of(b) < W)) {
        land_deferred(due);
      } else if (b >= 0) {
        refill(b);
        do {
          step(batch[b], false);
          refill(b);
        } while (deferred[b] < W && (batch[b].active == W || (batch[b].active > 0 && load_of(b) >= others(b))));
      } else {
        return;
      }
    }
  }

 private:
  int load_of(int b) const { return batch[b].active + queued[b]; }
  int fullest() const {
    int best = 0;
    for (int b = 1; b < bin_count; ++b)
      if (load_of(b) > load_of(best)) best = b;
    return load_of(best) > 0 ? best : -1;
  }
  int longest() const {  // line of members to be landed
    int best = 0;
    for (int b = 1; b < bin_count; ++b)
      if (deferred[b] > deferred[best]) best = b;
    return deferred[best] > 0 ? best : -1;
  }
  void land_deferred(int b) {
    for (int i = 0; i < W && deferred[b] > 0; ++i) enter(lander, i, landing[b][--deferred[b]]);
    step(lander, true);
  }
  int others(int b) const {
    int most = 0;
    for (int k = 0; k < bin_count; ++k)
      if (k != b && load_of(k) > most) most = load_of(k);
    return most;
  }
  void refill(int b) {
    Batch<W>& batch_b = batch[b];
    for (int i = 0; i < W && queued[b] > 0; ++i)
      if (batch_b.member[i] == nullptr) enter(batch_b, i, waiting[b][--queued[b]]);
  }
  void queue(Member& m) {
    const int b = bin_of(m.mode);
    waiting[b][queued[b]++] = &m;
  }

  // Takes the next member. Lanes share the shape of their branches; one whose curve starts below its floor goes alone.
  void next(Member& m) {
    for (m.index = q.take(q.context); m.index >= 0; m.index = q.take(q.context)) {
      start_member(q, common, m, scratch);
      if (first) {
        minus = m.sys.minus;
        plus = m.sys.plus;
        first = false;
      }
      if (alike(minus, m.sys.minus) && alike(plus, m.sys.plus)) return queue(m);
      run_alone(q, m);
    }
  }
  static bool alike(const Branch<double>& a, const Branch<double>& b) {
    return a.shape == b.shape && a.has_kink == b.has_kink;
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
    const bool curved = h[busy] == 0;
    if (curved) h = step_plain(b.sys, b.piece.s, p, q.rtol, q.atol);
    h = min(h, b.limit - b.s.t);
    const Watch<L>& watch = b.piece.watch[0];
    Side through[W];
    unsigned events = 0;
    const L rest = tail(watch.c, p, h);
    const unsigned lower = watch.has_lo ? suspects(b, watch, Side::lower, h, rest) : 0;
    const unsigned upper = watch.has_hi ? suspects(b, watch, Side::upper, h, rest) : 0;
    if (lower | upper) {
      if (to_land || 2 * __builtin_popcount(lower | upper) >= W) {
        const bool first_upper = __builtin_popcount(upper) > __builtin_popcount(lower);
        land_side(b, watch, first_upper ? Side::upper : Side::lower, first_upper ? upper : lower, p, h, through,
                  events);
        unsigned other = first_upper ? lower : upper;
        if (other != 0) {  // up to where the first side was met, less may be in doubt
          const Side side = first_upper ? Side::lower : Side::upper;
          if (events != 0) other = suspects(b, watch, side, h, tail(watch.c, p, h));
          if (other != 0) land_side(b, watch, side, other, p, h, through, events);
        }
      } else {
        for (unsigned left = lower | upper; left != 0; left &= left - 1) defer(b, __builtin_ctz(left));
        if (b.busy == 0) return;
      }
    }
    if ((q.observe & (ob_range | ob_dissipated)) != 0) observe(b, p, h);
    evaluate_four<L>({b.piece.s.x1, b.piece.s.x2, b.piece.s.y1, b.piece.s.y2}, p, h, b.s.z);
    if (b.mode.contact == 0) b.s.z[1] = b.sys.rig.v_b;
    b.s.t = b.s.t + h;
    finish_step(b, h, events, through, to_land);
  }

  void defer(Batch<W>& b, int i) {
    Member* m = b.member[i];
    m->side = b.on_lower[i] != 0 ? Side::lower : b.on_upper[i] != 0 ? Side::upper : Side::none;
    leave(b, i);
    const int bin = bin_of(m->mode);
    landing[bin][deferred[bin]++] = m;
  }

  // Shortens h of the lanes that meet the surface first, and notes them in `events`.
  void land_side(const Batch<W>& b, const Watch<Lanes<W>>& watch, Side side, unsigned asked, int p, Lanes<W>& h,
                 Side* through, unsigned& events) {
    const auto take = [&](int i, double t) {
      h.set(i, t);
      events |= 1u << i;
      through[i] = side;
    };
    Lanes<W> d[series_size];
    positive_inside(b, watch, side, p, d);
    const Landings<W> easy = land_lanes(d, p, h, asked);
    for (unsigned left = easy.found; left != 0; left &= left - 1)
      take(__builtin_ctz(left), easy.t[__builtin_ctz(left)]);
    for (unsigned left = easy.undecided; left != 0; left &= left - 1) {
      const int i = __builtin_ctz(left);
      double t = h[i];
      if (locate(b, watch, side, i, p, t)) take(i, t);
    }
  }

  void observe(Batch<W>& b, int p, const Lanes<W>& h) {
    for (int i = 0; i < W; ++i) {
      Member* m = b.member[i];
      if (m == nullptr || m->limit < q.t_end) continue;
      Strided z[4];
      for (int k = 0; k < 4; ++k) z[k] = {reinterpret_cast<const double*>(state_series(b.piece, k)) + i, W};
      observe_step(m->tally, q.observe, m->sys.rig, z, b.mode.contact, p, h[i]);
    }
  }

  void finish_step(Batch<W>& b, const Lanes<W>& h, unsigned events, const Side* through, bool all) {
    b.steps += Lanes<W>(1.0);
    if (b.mode.contact == 0) b.stick += h;
    b.on_lower = b.on_upper = typename Lanes<W>::Bits{};
    const unsigned going =
        mask_of<W>((b.s.t.v < b.limit.v) & (h.v > 0) & (b.steps.v < static_cast<double>(q.max_steps)));
    for (unsigned left = (all ? b.busy : events | ~going) & b.busy; left != 0; left &= left - 1) {
      const int i = __builtin_ctz(left);
      Member* m = b.member[i];
      const bool event = (events >> i & 1u) != 0;
      m->side = Side::none;
      leave(b, i);
      if (event && !change(*m, through[i])) {
        done(*m, Outcome::too_many_transitions);
      } else if (!event && !std::isfinite(m->s.z[0] + m->s.z[1] + m->s.z[2] + m->s.z[3])) {
        done(*m, Outcome::not_finite);
      } else if (!(m->s.t < m->limit) && m->limit >= q.t_end) {
        done(*m, Outcome::finished);
      } else if (m->tally.row.steps >= static_cast<double>(q.max_steps)) {
        done(*m, Outcome::too_many_steps);
      } else {
        if (!(m->s.t < m->limit)) begin_counting(q, *m);
        queue(*m);
      }
    }
  }

  bool change(Member& m, Side through) {
    Side on[watch_count] = {};
    const int before = m.mode.contact;
    change_plain(m.sys, m.s, m.mode, on, through);
    m.side = on[watch_contact];
    if (before != m.mode.contact && m.limit >= q.t_end)
      observe_transition(m.tally, q.points, before, m.mode.contact, m.s.t, m.s.z);
    return ++m.changes < q.max_transitions;
  }

  void done(Member& m, Outcome outcome) {
    report(q, m, outcome);
    next(m);
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
