// Sweeps, compiled once per instruction set.
#include <cstddef>
#include <new>

#include "stickslip/effects_ensemble.hpp"
#include "stickslip/ensemble.hpp"
#include "stickslip/kernel.hpp"

namespace stickslip::inline STICKSLIP_ISA {

namespace {

constexpr int width = STICKSLIP_LANES;

struct Alone {
  Common common;
  Member member;
  Piece<double> scratch;
};

bool repeats(const Structure& structure) {
  for (const Table& one : structure.table)
    if (one.period > 0) return true;
  return false;
}

}  // namespace

std::size_t sweep_workspace() {
  constexpr std::size_t plain = sizeof(Ensemble<width>), effects = sizeof(EffectEnsemble<width>);
  return plain > effects ? plain : effects;
}

void sweep(const SweepRequest& q, void* workspace) {
  if (q.lanes && q.structure->effects == 0) {
    auto* ensemble = new (workspace) Ensemble<width>(q);
    ensemble->run();
    return;
  }
  if (q.lanes && !repeats(*q.structure)) {  // cycles of a table in t would keep the lanes apart
    auto* ensemble = new (workspace) EffectEnsemble<width>(q);
    ensemble->run();
    return;
  }
  auto* alone = new (workspace) Alone;
  Member& member = alone->member;
  prepare(q, alone->common);
  for (member.index = q.take(q.context); member.index >= 0; member.index = q.take(q.context)) {
    start_member(q, alone->common, member, alone->scratch);
    run_alone(q, member);
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
