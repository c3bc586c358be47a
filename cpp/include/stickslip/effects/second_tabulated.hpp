// Another curve beside the first.
#pragma once

#include "stickslip/curve.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct SecondTabulated : Curve<SecondTabulated, 1> {};

}  // namespace stickslip::inline STICKSLIP_ISA
