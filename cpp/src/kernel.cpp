// Compiled once per instruction set (cmake/stickslip.cmake); everything here lives in the namespace
// stickslip::STICKSLIP_ISA.
#include "stickslip/isa.hpp"

namespace stickslip::STICKSLIP_ISA {

int kernel_lanes() noexcept { return STICKSLIP_LANES; }

}  // namespace stickslip::STICKSLIP_ISA
