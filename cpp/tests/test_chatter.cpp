// A run whose transitions pile up ends with a status, alone and in lanes.
//
// Kinetic friction above the static limit (refused by the face) has no motion: let go, the block is pushed back at once.
#include <memory>

#include "stickslip/effects_ensemble.hpp"
#include "stickslip/ensemble.hpp"
#include "support.hpp"

using namespace support;

namespace {

struct Swept {
  long next = 0;
  std::array<double, 3> outcome{}, t{};
};

template <class Ensemble>
Swept sweep_static(const Setup& setup) {
  std::array<double, parameter_count + state_count> base{};
  for (std::size_t i = 0; i < parameter_count; ++i) base[i] = setup.p[i];
  for (std::size_t i = 0; i < state_count; ++i) base[parameter_count + i] = setup.z[i];
  const int varied = slot("coulomb.static_minus");
  const std::array<double, 3> values{0.5, 1.2, 0.6};
  Swept out;
  SweepRequest q{};
  q.structure = &setup.structure;
  q.base = base.data();
  q.varied = &varied;
  q.n_varied = 1;
  q.values = values.data();
  q.t_end = 40;
  q.rtol = q.atol = 1e-10;
  q.lanes = true;
  q.max_transitions = 1000000;
  q.max_steps = 5000000;
  q.context = &out;
  q.take = [](void* c) {
    auto& all = *static_cast<Swept*>(c);
    return all.next < 3 ? all.next++ : -1L;
  };
  q.done = [](void* c, long member, const SweepRow& row, const double*) {
    static_cast<Swept*>(c)->outcome[static_cast<std::size_t>(member)] = row.outcome;
    static_cast<Swept*>(c)->t[static_cast<std::size_t>(member)] = row.t;
  };
  std::make_unique<Ensemble>(q)->run();
  return out;
}

}  // namespace

TEST_CASE("transitions that pile up end a run") {
  const auto alone = run<double>(block_on_belt(0.5, 0.8, 0.2), 40.0, 1e-10);
  CHECK(alone.summary.outcome == Outcome::chatter);
  CHECK(alone.summary.t == doctest::Approx(2.5));  // where k x reaches the static limit
  CHECK(run<double>(block_on_belt(1.2, 0.8, 0.2), 40.0, 1e-10).summary.outcome == Outcome::finished);
  Setup plain = block_on_belt(1.0, 0.8, 0.2), effects = plain;
  effects.structure.effects = effect("block_viscous_damping");
  for (const Swept& swept : {sweep_static<Ensemble<2>>(plain), sweep_static<EffectEnsemble<2>>(effects)}) {
    CHECK(swept.outcome[0] == static_cast<double>(Outcome::chatter));
    CHECK(swept.t[0] == doctest::Approx(2.5));
    CHECK(swept.outcome[1] == static_cast<double>(Outcome::finished));
    CHECK(swept.outcome[2] == static_cast<double>(Outcome::chatter));
    CHECK(swept.t[2] == doctest::Approx(3.0));
  }
}
