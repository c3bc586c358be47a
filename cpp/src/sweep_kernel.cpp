// Sweeps, compiled once per instruction set: lanes for models without effects, one at a time for the rest.
#include <cstddef>
#include <new>

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

}  // namespace

std::size_t sweep_workspace() {
  return sizeof(Ensemble<width>) > sizeof(Alone) ? sizeof(Ensemble<width>) : sizeof(Alone);
}

void sweep(const SweepRequest& q, void* workspace) {
  if (q.lanes && q.structure->effects == 0) {
    auto* ensemble = new (workspace) Ensemble<width>(q);
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
