// Many trajectories of a model with effects: lanes that share a mode run together, and the mode most wait for is next.
#pragma once

#include "stickslip/alone.hpp"
#include "stickslip/effects_landing.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <int W>
struct EffectEnsemble {
  static constexpr int pool_size = 8 * W;
  const SweepRequest& q;
  int order;
  EffectBatch<W> batch;
  Member pool[pool_size];
  Member* waiting[pool_size];
  std::uint64_t wanted[pool_size];  // their modes
  int waits = 0;
  Common common;
  Piece<double> scratch;
  Company company;

  explicit EffectEnsemble(const SweepRequest& request)
      : q(request), order(order_for(tolerance_share * (request.rtol > 0 ? request.rtol : request.atol))) {}

  void run() {
    prepare(q, common);
    for (Member& m : pool) next(m);
    while (waits > 0) {
      int others = 0;
      refill(wanted[most_wanted(others)]);
      do {
        step();
        if (batch.active == 0) break;
        if (batch.active < W && changed) refill(key_of(batch.mode));
        if (2 * batch.active <= W && changed) most_wanted(others);
        changed = false;
      } while (2 * batch.active > W || batch.active >= others);
      for (unsigned left = batch.busy; left != 0; left &= left - 1) {
        Member* m = batch.member[__builtin_ctz(left)];
        leave(batch, __builtin_ctz(left));
        wait(*m);
      }
    }
  }

 private:
  bool changed = false;  // who waits, in this step

  void wait(Member& m) {
    wanted[waits] = key_of(m.mode);
    waiting[waits++] = &m;
    changed = true;
  }
  // One that waits with the most others in its mode, and how many they are.
  int most_wanted(int& many) const {
    int best = 0;
    many = 0;
    for (int i = 0; i < waits; ++i) {
      int count = 0;
      for (int j = 0; j < waits; ++j) count += wanted[j] == wanted[i] ? 1 : 0;
      if (count > many) {
        many = count;
        best = i;
      }
    }
    return best;
  }
  // Members that want this mode fill the idle lanes.
  void refill(std::uint64_t mode) {
    for (int j = waits - 1; j >= 0 && batch.active < W; --j) {
      if (wanted[j] != mode) continue;
      enter(batch, __builtin_ctz(~batch.busy), waiting[j]);
      waiting[j] = waiting[--waits];
      wanted[j] = wanted[waits];
    }
  }
  // Takes the next member. Lanes share the shape of their branches; one that differs goes alone.
  void next(Member& m) {
    for (m.index = q.take(q.context); m.index >= 0; m.index = q.take(q.context)) {
      start_member(q, common, m, scratch);
      if (company.takes(m)) return wait(m);
      run_alone(q, m);
    }
  }

  void step() {
    using L = Lanes<W>;
    EffectBatch<W>& b = batch;
    if (b.active < W) fill_idle(b);
    L h;
    expand(b.sys, b.mode, b.s, order, b.piece, h);
    h = step_length(b.sys, b.mode, b.s, b.piece, order, q.rtol, q.atol);
    settle_step(b.sys, b.mode, b.s, b.piece, order, h, q.rtol, q.atol);
    const L left = b.limit - b.s.t, least = abs(b.s.t) * std::numeric_limits<double>::epsilon();
    const unsigned small = mask_of<W>((h.v < left.v) & (h.v <= least.v));
    h = min(h, left);
    Exit<double> exits[W];
    const unsigned events = land(b, order, h, exits);
    observe(q, b, order, h);
    L z[state_count];
    piece_state(b.sys, b.mode, b.piece, b.s, order, h, z);
    for (int k = 0; k < state_count; ++k) b.s.z[k] = z[k];
    b.s.t = b.s.t + h;
    b.steps += L(1.0);
    if (b.mode.contact == 0) b.stick += h;
    leave_surfaces(b, order, h);
    const unsigned going = mask_of<W>((b.s.t.v < b.limit.v) & (b.steps.v < static_cast<double>(q.max_steps)));
    for (unsigned ends = (events | small | ~going) & b.busy; ends != 0; ends &= ends - 1) {
      const int i = __builtin_ctz(ends);
      settle(i, (events >> i & 1u) != 0 ? &exits[i] : nullptr, (small >> i & 1u) != 0);
    }
  }

  // Lane i leaves: for another mode, or for good.
  void settle(int i, const Exit<double>* exit, bool small) {
    Member* m = batch.member[i];
    const Watch<Lanes<W>>* watch = exit == nullptr ? nullptr : &batch.piece.watch[exit->watch];
    leave(batch, i);
    Outcome outcome = small ? Outcome::step_too_small : Outcome::finished;
    if (watch != nullptr) outcome = change(q, *m, watch->id, exit->side, scratch);
    if (goes_on(q, *m, outcome)) {
      wait(*m);
    } else {
      report(q, *m, outcome);
      next(*m);
    }
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
