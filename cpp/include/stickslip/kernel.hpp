// The kernels' entry points. Ordinary code calls the functions of namespace stickslip::dispatch, which pick the build
// for this processor; the builds themselves live in stickslip::baseline, ::avx2 and ::avx512.
#pragma once

#include <cstddef>

#include "stickslip/isa.hpp"
#include "stickslip/sweep_request.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// One trajectory with up to `max_seeds` derivatives. Never allocates; results go to `sink` as they come.
void simulate(const stickslip_abi::Request& request, const stickslip_abi::Sink& sink, stickslip_abi::Summary& summary);

// Trajectories taken from the request's queue until it is empty, in memory of sweep_workspace() bytes aligned to 128.
void sweep(const stickslip_abi::SweepRequest& request, void* workspace);
std::size_t sweep_workspace();

}  // namespace stickslip::inline STICKSLIP_ISA

namespace stickslip::dispatch {

constexpr int max_seeds = 12;
constexpr int group_seeds = 8;  // of each of several groups: as many as stay in registers, which 12 do not quite

// More seeds are taken in groups of even size: seeds first <= s < first + count.
struct SeedGroup {
  int first, count;
};
constexpr int seed_groups(int seeds) { return seeds <= max_seeds ? 1 : (seeds + group_seeds - 1) / group_seeds; }
constexpr SeedGroup seed_group(int seeds, int group) {
  const int groups = seed_groups(seeds), first = seeds * group / groups;
  return {first, seeds * (group + 1) / groups - first};
}

void simulate(const stickslip_abi::Request& request, const stickslip_abi::Sink& sink, stickslip_abi::Summary& summary);
void sweep(const stickslip_abi::SweepRequest& request, void* workspace);
std::size_t sweep_workspace();

}  // namespace stickslip::dispatch
