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
  std::vector<double> low, high, work;                 // (2n,), (2n,), (contacts,), empty where not asked for
  stickslip_abi::Summary summary;
  std::size_t seeds = 0, states = 0, contacts = 0, senses = 0;
};

// `summed` says what is summed up on the way, into the record's own room.
struct Summed {
  double after = 0;
  bool extremes = false, work = false;
};

// Runs the request on the kernel for this processor, its seeds in groups of what one kernel carries.
BodiesRecord record_bodies(const stickslip_abi::BodiesRequest& request, const Summed& summed,
                           bool (*interrupted)(void*));

}  // namespace stickslip
