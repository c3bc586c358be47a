// One batch of a sweep: members are handed out one by one, so that no lane idles. Threads are the business of the caller.
#pragma once

#include <vector>

#include "stickslip/sweep_request.hpp"

namespace stickslip {

struct SweepResult {
  std::vector<double> rows;    // members x sweep_row_size
  std::vector<double> points;  // members x points x 5, the last release first; NaN where there is none
  bool interrupted = false;
};

// `request.take`, `.done` and `.context` are set here. `interrupted` is asked between members, every 20 ms.
SweepResult sweep(stickslip_abi::SweepRequest request, long members, bool (*interrupted)());

}  // namespace stickslip
