// Laws, forces and speeds as tapes: nodes, each an operation on nodes before it. Plain data, as in interface.hpp.
#pragma once

namespace stickslip_abi {

enum class Op : int {
  parameter = 0,  // a: its place among the parameters; a constant is a parameter
  u,              // |v|
  v,
  t,
  dwell,       // time since the contact came to rest
  state,       // a: which of the law's, or of the push's, own
  coordinate,  // a: which; q
  velocity,    // a: which; q'
  distance,    // a: of which speed; x
  prescribed,  // a: which speed; V
  add,
  subtract,
  multiply,
  divide,
  power,
  negate,
  absolute,
  minimum,
  maximum,
  sign,
  exponential,
  logarithm,
  square_root,
  sine,
  cosine,
  tangent,
  tanh,
  asinh,
  count
};

struct Node {
  Op op;
  int a, b;
};

// Formulas of one direction of slip. A rigid law: force is the magnitude R in slip, T = sgn(v) R, and `limit` what it
// holds at rest. A compliant one (limit -1) has no stick: force is T itself.
struct BranchTape {
  const Node* nodes;
  int count;
  int force, limit;
  const int* rates;  // a node for every state of the law
};

struct LawTape {
  BranchTape branch[2];  // v < 0, v > 0
  int states;
};

// A force F that an effect adds on a direction g, and states of its own; both read q, q', x, V and t. One whose g is zero
// moves nothing: its states follow the motion.
struct PushTape {
  BranchTape formulas;
  int states;
};

// V(t), a formula of t from begins[i] on; the first holds before too.
struct SpeedTape {
  const double* begins;
  const BranchTape* pieces;
  int count;
};

}  // namespace stickslip_abi
