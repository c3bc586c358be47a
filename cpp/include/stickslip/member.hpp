// One trajectory of a sweep while it is in no batch: how it starts, changes its mode and is reported.
#pragma once

#include "stickslip/chatter.hpp"
#include "stickslip/start.hpp"
#include "stickslip/table.hpp"
#include "stickslip/tally.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// A trajectory between two batches.
struct Member {
  System<double> sys;
  State<double> s;
  Mode mode;
  Side on[watch_count];  // of the surfaces it has just left
  double limit;          // time at which it must be looked at: `after`, then t_end
  long index;
  Chatter<double> chatter;
  Tally tally;
};

// What all members share, and whether the law is part of it.
struct Common {
  System<double> sys;
  bool law;
};

inline void prepare(const SweepRequest& q, Common& c) {
  c.law = true;
  for (int j = 0; j < q.n_varied; ++j) c.law &= q.varied[j] < law_first || q.varied[j] >= effect_first;
  for (int i = 0; i < parameter_count; ++i) c.sys.p[i] = q.base[i];
  c.sys.structure = *q.structure;
  if (c.law) build_law(c.sys);
}

// Sets up member m.index from its row of values and finds its mode.
inline void start_member(const SweepRequest& q, const Common& common, Member& m, Piece<double>& scratch) {
  for (int i = 0; i < parameter_count; ++i) m.sys.p[i] = q.base[i];
  for (int i = 0; i < state_count; ++i) m.s.z[i] = q.base[parameter_count + i];
  for (int j = 0; j < q.n_varied; ++j) {
    const int slot = q.varied[j];
    (slot < parameter_count ? m.sys.p[slot] : m.s.z[slot - parameter_count]) = q.values[m.index * q.n_varied + j];
  }
  m.s.t = 0;
  m.sys.structure = *q.structure;
  if (common.law) {
    m.sys.minus = common.sys.minus;
    m.sys.plus = common.sys.plus;
  } else {
    build_law(m.sys);
  }
  build_rig(m.sys);
  build_tables(m.sys);
  for (Side& side : m.on) side = Side::none;
  m.mode = Mode{};
  set_modes(m.sys, m.s, m.mode, m.on, 2, scratch);
  m.chatter.seen = 0;
  clear(m.tally);
  m.limit = q.after > 0 ? q.after : q.t_end;
}

inline bool alike(const Branch<double>& a, const Branch<double>& b) {
  return a.curve == b.curve && a.has_kink == b.has_kink;
}

inline std::uint32_t variants_of(const System<double>& sys) {
  std::uint32_t bits = 0;
  const auto one = [&]<class E> {
    if constexpr (requires { &E::template variant<double>; })
      bits |= E::variant(Numbers<E, double>{sys.p.p + first_slot<E>}) ? bit_of<E> : 0;
  };
  [&]<class... E>(TypeList<E...>) { (one.template operator()<E>(), ...); }(Effects{});
  return bits;
}

// Who can share a batch: those like the first to come in what decides the course of a computation.
struct Company {
  Branch<double> minus, plus;
  std::uint32_t variants = 0;  // one bit an effect
  bool first = true;

  bool takes(const Member& m) {
    if (first) {
      minus = m.sys.minus;
      plus = m.sys.plus;
      variants = variants_of(m.sys);
      first = false;
    }
    return alike(minus, m.sys.minus) && alike(plus, m.sys.plus) && variants == variants_of(m.sys);
  }
};

// Observables count from here.
inline void begin_counting(const SweepRequest& q, Member& m) {
  const double steps = m.tally.row.steps;
  clear(m.tally);
  m.tally.row.steps = steps;
  m.limit = q.t_end;
}

inline void report(const SweepRequest& q, Member& m, Outcome outcome) {
  SweepRow& row = m.tally.row;
  for (int i = 0; i < state_count; ++i) row.final_state[i] = m.s.z[i];
  row.t = m.s.t;
  row.outcome = static_cast<double>(outcome);
  q.done(q.context, m.index, row, &m.tally.points[0][0]);
}

// Changes the mode of a member that has met a surface. Finished: it goes on.
inline Outcome change(const SweepRequest& q, Member& m, int id, Side through, Piece<double>& scratch) {
  m.on[id] = Side::none;
  const int before = m.mode.contact;
  change_mode(m.sys, m.s, m.mode, m.on, id, through, scratch);
  if (before != m.mode.contact && m.limit >= q.t_end)
    observe_transition(m.tally, q.points, before, m.mode.contact, m.s.t, m.s.z);
  if (m.chatter.sees(m.s.t, natural_frequency(m.sys))) return Outcome::chatter;
  return m.chatter.seen < q.max_transitions ? Outcome::finished : Outcome::too_many_transitions;
}

// Where a member is after a step: does it go on? Then the outcome is `finished` and its time below its limit.
inline bool goes_on(const SweepRequest& q, Member& m, Outcome& outcome) {
  double sum = 0;
  for (const double z : m.s.z) sum += z;
  if (!std::isfinite(sum)) outcome = Outcome::not_finite;
  if (outcome != Outcome::finished) return false;
  if (!(m.s.t < m.limit) && m.limit >= q.t_end) return false;
  if (m.tally.row.steps >= static_cast<double>(q.max_steps)) {
    outcome = Outcome::too_many_steps;
    return false;
  }
  if (!(m.s.t < m.limit)) begin_counting(q, m);
  return true;
}

}  // namespace stickslip::inline STICKSLIP_ISA
