// What crosses the border for many trajectories: plain data, as in interface.hpp.
#pragma once

#include "stickslip/interface.hpp"

namespace stickslip_abi {

// What a sweep can keep of each trajectory, one bit each.
enum Observable : std::uint32_t {
  ob_final = 1u << 0,
  ob_stick = 1u << 1,
  ob_counts = 1u << 2,  // transitions, releases, period and its spread
  ob_range = 1u << 3,
  ob_dissipated = 1u << 4,
  ob_points = 1u << 5  // states at the last releases
};

// One trajectory's results. Counted from `after` on.
struct SweepRow {
  double final_state[state_count];
  double t;
  double stick_time;
  double transitions, releases, slips;  // slips: releases from stick alone
  double first_release, last_release, interval_squares;
  double state_min[4], state_max[4];
  double dissipated;
  double steps;
  double outcome;
};
constexpr int max_sweep_points = 64;
constexpr int sweep_row_size = sizeof(SweepRow) / sizeof(double);

// Many trajectories of one structure. Member m takes `base` with value j of its row in slot `varied[j]` (parameters,
// then states). `take` hands out member numbers, negative when there are none left; `done` receives each result.
struct SweepRequest {
  const Structure* structure;
  const double* base;  // parameter_count + state_count
  const int* varied;   // n_varied
  int n_varied;
  const double* values;  // members x n_varied
  double t_end, after;
  double rtol, atol;
  std::uint32_t observe;
  int points;  // how many of the last releases to keep
  bool lanes;  // false: one at a time, the reference for the lanes
  long max_transitions, max_steps;
  void* context;
  long (*take)(void*);
  void (*done)(void*, long member, const SweepRow&, const double* points);  // points x (1 + 4): t and state, last first
};

}  // namespace stickslip_abi
