// A whole trajectory of a rig of bodies kept in memory.
#pragma once

#include <cstddef>
#include <vector>

#include "stickslip/bodies/interface.hpp"

namespace stickslip {

struct BodiesRecord {
  std::vector<double> t, state;                        // (n,), (n, d)
  std::vector<signed char> mode;                       // (n, contacts)
  std::vector<double> sensitivity;                     // (n, d, seeds)
  std::vector<double> sensed, sensed_sensitivity;      // (n, s), (n, s, seeds): what is sensed beside the state
  std::vector<double> event_t, event_state;            // (k,), (k, d)
  std::vector<signed char> event_before, event_after;  // (k, contacts)
  std::vector<double> event_sensitivity;               // (k, 1 + d, seeds): of (t, state)
  std::vector<double> kink_t;                          // (j,)
  stickslip_abi::Summary summary;
  std::size_t seeds = 0, states = 0, contacts = 0, senses = 0;
};

// Runs the request on the kernel for this processor, its seeds in groups of what one kernel carries.
BodiesRecord record_bodies(const stickslip_abi::BodiesRequest& request, bool (*interrupted)(void*));

}  // namespace stickslip
