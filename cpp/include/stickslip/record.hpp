// A whole trajectory kept in memory: what simulate() of the Python face returns.
#pragma once

#include <cstddef>
#include <vector>

#include "stickslip/interface.hpp"

namespace stickslip {

struct Record {
  std::vector<double> t, state;              // (n,), (n, state_count)
  std::vector<signed char> mode;             // (n,)
  std::vector<double> sensitivity;           // (n, state_count, seeds)
  std::vector<double> event_t, event_state;  // (k,), (k, state_count)
  std::vector<signed char> event_before, event_after;
  std::vector<double> event_sensitivity;  // (k, 1 + state_count, seeds): of (t, state)
  std::vector<double> kink_t;             // (j,)
  stickslip_abi::Summary summary;
  std::size_t seeds = 0;
};

// Runs the request on the kernel for this processor, its seeds in groups of what one kernel carries. `interrupted` is
// asked now and then and ends the run.
Record record(const stickslip_abi::Request& request, bool (*interrupted)(void*));

}  // namespace stickslip
