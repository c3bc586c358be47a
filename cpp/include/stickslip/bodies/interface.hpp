// Plain data that crosses into the kernel of rigs of bodies:
//
//   M q'' + C q' + K q = force + sum over speeds s of (pull_x_s x_s + pull_v_s V_s(t)) - sum over contacts j of d_j T_j
//   x_s' = V_s,  v_j = d_j . q' - V_(speed of j)
//   and on the right + sum over pushes e of g_e F_e(q, q', x, V, t), the forces that effects add.
//
// A law is a tape (nodes.hpp). No templates and nothing of the standard library, as in interface.hpp.
#pragma once

#include "stickslip/bodies/nodes.hpp"
#include "stickslip/interface.hpp"

namespace stickslip_abi {

constexpr int most_law_states = 16;

struct Bodies {
  int n, contacts, speeds, parameters, states;  // states: of all laws, then of all pushes
  const LawTape* laws;                          // a law for every contact
  const int* contact_speed;                     // which speed it rubs on; -1: ground
  const SpeedTape* speed;
  int pushes = 0;
  const PushTape* push = nullptr;
};

// The numbers of a rig in a row, and the same places for seeds: M, C, K (n x n), force (n), D (contacts x n), G (pushes x
// n), pull_x, pull_v (speeds x n), parameters, then the start: q, q', states of laws and pushes, x of the speeds, and dwell of the contacts.
struct BodiesLayout {
  int M, C, K, force, D, G, pull_x, pull_v, parameters, initial, dwell, size, state;
};
constexpr BodiesLayout layout_of(const Bodies& b) {
  BodiesLayout l{};
  l.C = b.n * b.n;
  l.K = 2 * l.C;
  l.force = 3 * l.C;
  l.D = l.force + b.n;
  l.G = l.D + b.contacts * b.n;
  l.pull_x = l.G + b.pushes * b.n;
  l.pull_v = l.pull_x + b.speeds * b.n;
  l.parameters = l.pull_v + b.speeds * b.n;
  l.initial = l.parameters + b.parameters;
  l.state = 2 * b.n + b.states + b.speeds;
  l.dwell = l.initial + l.state;
  l.size = l.dwell + b.contacts;
  return l;
}

// What is summed up of the run from `after` on, null where it is not asked for: extremes of q and q' (2n), work of the
// friction in every contact.
struct BodiesTotals {
  double after = 0;
  double *low = nullptr, *high = nullptr, *work = nullptr;
};

struct BodiesRequest {
  const Bodies* bodies;
  const double* values;      // layout.size
  const signed char* modes;  // of the contacts at the start: -1, 0, 1; 2: found from the state
  double t_start, t_end;
  const double* t_eval;  // increasing, within [t_start, t_end]; null: every step's end
  long n_eval;
  double rtol, atol;
  Locator locator;
  int n_seeds;
  const double* seeds;  // n_seeds x layout.size
  long max_transitions, max_steps;
  bool sensed = false;    // samples carry what is sensed beside the state
  BodiesTotals totals{};  // without seeds
};

// What is sensed beside the state: q'', T of the contacts, F of the pushes, V of the speeds.
constexpr int sensed_count(const Bodies& b) { return b.n + b.contacts + b.pushes + b.speeds; }

struct BodiesTransition {
  double t;
  const signed char *before, *after;  // modes of the contacts
  bool kink;                          // all modes stay: a formula or a speed goes over to another piece
  const double* state;                // layout.state
  const double* derivatives;          // of (t, state): (1 + layout.state) x seeds
};

struct BodiesSink {
  void* context;
  // `state` has layout.state numbers, then what is sensed, if that was asked for; `derivatives` a row of seeds for each.
  void (*sample)(void*, double t, const double* state, const double* derivatives, const signed char* modes);
  void (*transition)(void*, const BodiesTransition&);
  bool (*interrupted)(void*);
};

}  // namespace stickslip_abi
