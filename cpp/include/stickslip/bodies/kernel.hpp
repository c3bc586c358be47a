// The kernel's entry points for rigs of bodies; dispatch picks the build for this processor.
#pragma once

#include <cstddef>

#include "stickslip/bodies/interface.hpp"
#include "stickslip/isa.hpp"

namespace stickslip::inline STICKSLIP_ISA {

// Memory that `simulate_bodies` needs, aligned to 64.
std::size_t bodies_workspace(const stickslip_abi::BodiesRequest& request);

// One trajectory with up to dispatch::max_seeds derivatives. Never allocates; results go to `sink` as they come.
void simulate_bodies(const stickslip_abi::BodiesRequest& request, const stickslip_abi::BodiesSink& sink,
                     stickslip_abi::Summary& summary, void* workspace);

}  // namespace stickslip::inline STICKSLIP_ISA

namespace stickslip::dispatch {

std::size_t bodies_workspace(const stickslip_abi::BodiesRequest& request);
void simulate_bodies(const stickslip_abi::BodiesRequest& request, const stickslip_abi::BodiesSink& sink,
                     stickslip_abi::Summary& summary, void* workspace);

}  // namespace stickslip::dispatch
