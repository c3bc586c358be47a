// What crosses the border between the kernels (one build per instruction set) and the rest: plain data, no templates.
//
// Kernels never allocate and never call the standard library's containers, so that no inline function compiled for
// AVX can be merged into code that must run without it. This namespace is the same in every build.
#pragma once

#include <cstdint>

#include "stickslip/structure.hpp"

namespace stickslip_abi {

enum class Locator : int { henon = 0, bracket = 1 };

enum class Outcome : int {
  finished = 0,
  chatter,
  not_finite,
  step_too_small,
  too_many_transitions,
  interrupted,
  too_many_steps
};

constexpr long most_steps = 5'000'000;  // of a trajectory, unless told otherwise

struct Transition {
  double t;
  int before, after;          // -1, 0, 1
  bool kink;                  // the contact mode stays; a branch saturates or an effect switches
  const double* state;        // state_count
  const double* derivatives;  // of (t, state) with respect to each seed: (1 + state_count) x seeds
};

// One trajectory to compute. Pointers are borrowed for the call.
struct Request {
  const Structure* structure;
  const double* parameters;  // parameter_count
  const double* initial;     // state_count
  double t_start, t_end;
  int contact;           // -1, 0, 1: the mode to start in; 2: found from the state
  const double* t_eval;  // increasing, within [t_start, t_end]; null: every step's end
  long n_eval;
  double rtol, atol;
  Locator locator;
  int n_seeds;
  const double* seeds;  // n_seeds x (parameter_count + state_count)
  long max_transitions, max_steps;
  int order;                // 0: from the tolerance
  double fixed_step;        // 0: from the tolerance
  std::uint32_t plain = 0;  // states whose derivatives no sample needs, by bit: they are 0 there
};

// Where results go. `sample` is called in time order, with the derivatives laid out as state x seeds.
struct Sink {
  void* context;
  void (*sample)(void*, double t, const double* state, const double* derivatives, int mode);
  void (*transition)(void*, const Transition&);
  bool (*interrupted)(void*);
};

struct Summary {
  Outcome outcome = Outcome::finished;
  double t = 0;
  long steps = 0, transitions = 0, kinks = 0;
  int contact = 0;
  double largest_switch = 0;  // largest |S| left at a located transition
  double dissipated = 0;
};

}  // namespace stickslip_abi
