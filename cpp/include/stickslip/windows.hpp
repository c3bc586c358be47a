// Many short trajectories of one rig and law, each sampled at its own times: what a fit evaluates at every turn.
#pragma once

#include "stickslip/interface.hpp"

namespace stickslip {

// Pointers are borrowed for the call. Window w starts at its first sample, t[offset[w]], and ends at its last.
struct WindowsRequest {
  const stickslip_abi::Structure* const* structures;  // one a set: they may differ by where curves have their knots
  const double* parameters;                           // sets x parameter_count
  const int* set;                                     // (windows): which set
  const double* initial;                              // windows x state_count
  const int* contact;                                 // (windows): as in Request
  const double* t;                                    // (samples), increasing within a window
  const long* offset;                                 // (windows + 1)
  long windows;
  double rtol, atol;
  int n_seeds;
  const double* seeds;  // n_seeds x (parameter_count + state_count)
  const int* column;    // (n_seeds): where the derivatives with respect to a seed go
  int columns;          // of the derivatives; those of no seed are 0
  const int* kept;      // (n_kept): the states whose derivatives are wanted
  int n_kept;
  long max_transitions, max_steps;
  int order;
};

// Where results go; the caller's memory.
struct WindowsResult {
  double* state;                    // samples x state_count
  double* slopes;                   // n_kept x samples x columns
  signed char* mode;                // (samples)
  stickslip_abi::Outcome* outcome;  // (windows); samples of a window that did not finish are not all written
};

// Runs the windows on `threads` threads. `interrupted` is asked by the calling one; false if it said yes.
bool simulate_windows(const WindowsRequest& request, const WindowsResult& out, int threads, bool (*interrupted)(void*));

}  // namespace stickslip
