// A curve of one variable: a force on a body, or a factor of friction.
#pragma once

#include "stickslip/curve.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct Tabulated : Curve<Tabulated, 0> {};

}  // namespace stickslip::inline STICKSLIP_ISA
