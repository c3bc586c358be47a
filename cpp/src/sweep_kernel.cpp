// Sweeps, compiled once per instruction set: lanes for models without effects, one at a time for the rest.
#include <cstddef>
#include <new>

#include "stickslip/ensemble.hpp"
#include "stickslip/kernel.hpp"

namespace stickslip::inline STICKSLIP_ISA {

namespace {

constexpr int width = STICKSLIP_LANES;

}  // namespace

std::size_t sweep_workspace() {
  return sizeof(Ensemble<width>) > sizeof(Member) + sizeof(Piece<double>) ? sizeof(Ensemble<width>)
                                                                          : sizeof(Member) + sizeof(Piece<double>);
}

void sweep(const SweepRequest& q, void* workspace) {
  if (q.lanes && q.structure->effects == 0) {
    auto* ensemble = new (workspace) Ensemble<width>(q);
    ensemble->run();
    return;
  }
  auto* member = new (workspace) Member;
  auto* scratch = new (static_cast<char*>(workspace) + (sizeof(Member) + 127) / 128 * 128) Piece<double>;
  for (member->index = q.take(q.context); member->index >= 0; member->index = q.take(q.context)) {
    start_member(q, *member, *scratch);
    run_alone(q, *member);
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
