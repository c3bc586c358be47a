// Sweeps over threads: members are handed out one by one, so that none idles.
#pragma once

#include <vector>

#include "stickslip/sweep_request.hpp"

namespace stickslip {

struct SweepResult {
  std::vector<double> rows;    // members x sweep_row_size
  std::vector<double> points;  // members x points x 5, the last release first; NaN where there is none
  bool interrupted = false;
};

// `request.take`, `.done` and `.context` are set here. `interrupted` is asked from the calling thread.
SweepResult sweep(stickslip_abi::SweepRequest request, long members, int threads, bool (*interrupted)());

}  // namespace stickslip
