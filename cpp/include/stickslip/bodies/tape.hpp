// A law's tape made ready for one mode: what is constant is folded, what is linear in u (of a speed: in t) becomes two
// numbers, abs, sign, min and max are frozen on a side and cost nothing, and only the rest is left to be expanded.
#pragma once

#include "stickslip/bodies/arena.hpp"
#include "stickslip/bodies/functions.hpp"
#include "stickslip/bodies/interface.hpp"
#include "stickslip/bodies/interval.hpp"
#include "stickslip/series.hpp"

namespace stickslip::inline STICKSLIP_ISA {

using namespace stickslip_abi;  // NOLINT(google-build-using-namespace): plain data shared by every build

enum class Form : signed char { constant, affine, curved };

// What a tape reads, as series that are filled while it runs. `base` is u, of a speed t.
template <class T>
struct Reads {
  const T* parameters = nullptr;
  const T* base = nullptr;
  const T* time = nullptr;
  const T* dwell = nullptr;
  const T* const* states = nullptr;
  double direction = 0;  // of v; 0 at rest, where u and v are 0
  bool base_is_time = false;
  const T *coordinates = nullptr, *velocities = nullptr, *distances = nullptr, *speeds = nullptr;  // rows of series
};

enum class Code : signed char {
  combine,  // x a + y b + level
  multiply,
  divide,
  over,         // level / b
  power,        // a^x, x a constant
  whole_power,  // a^x, x a whole number above 1
  open_power,   // a^b
  exponential,
  logarithm,
  sine,
  cosine,
  tangent,
  tanh,
  asinh
};

template <class T>
struct Instruction {
  Code code;
  int node;
  const T *a, *b;
  T x, y, level;
  T *c, *aux;
};

template <class T>
struct NodeFacts {
  Form form;
  bool placed;       // its series is filled by an instruction or by others
  signed char side;  // of abs, sign, min, max: 1 where the surface a or a - b is above 0; 0: not known yet
  bool watched;      // its side may change
  T level, slope;    // constant: level; affine: level + slope base
  T* c;
  T *own, *aux;
  Real<T> now;     // value at the start of the piece
  Real<T> weight;  // derivative of the force by it, there
  Crossings<T>* crossings;
  const Instruction<T>* made;  // what fills its series
};

constexpr int aux_series = 3;  // most that an operation keeps beside its own, but for whole powers
constexpr int largest_whole_power = 64;
constexpr int largest_base = 2 * series_size;  // beside a power that is not whole: the largest that its base has been

inline bool is_piecewise(Op op) {
  return op == Op::absolute || op == Op::sign || op == Op::minimum || op == Op::maximum;
}
inline bool is_leaf(Op op) { return op <= Op::prescribed; }
inline bool is_binary(Op op) { return (op >= Op::add && op <= Op::power) || op == Op::minimum || op == Op::maximum; }

// The whole number above 1 that the exponent of a node is, or 0.
inline int whole_exponent(const BranchTape& tape, const Node& node, const double* parameters) {
  if (node.op != Op::power || tape.nodes[node.b].op != Op::parameter) return 0;
  const double p = parameters[tape.nodes[node.b].a];
  return p == std::floor(p) && p >= 2 && p <= largest_whole_power ? static_cast<int>(p) : 0;
}
constexpr int squarings(int p) { return p < 2 ? 0 : 1 + squarings(p / 2); }

template <class T>
struct Tape {
  const BranchTape* formulas = nullptr;
  Reads<T> reads;
  NodeFacts<T>* node = nullptr;
  Instruction<T>*inner = nullptr, *outer = nullptr;  // what the motion hangs on; what is only watched
  int inners = 0, outers = 0;
  int* surfaces = nullptr;  // nodes that are watched as series of their own: their `surface` series
  int surface_count = 0;
  bool jumps = false;  // a surface is that of a sign
  T* surface_series = nullptr;
  bool *wanted = nullptr, *marks = nullptr;
  Range* ranges = nullptr;  // room to evaluate surfaces in
  Real<T>* reals = nullptr;
  Dual<4>* slopes = nullptr;
  T* numbers = nullptr;
  int first_id = 0;              // of its switching functions: one a node
  std::uint64_t* key = nullptr;  // of the function that a node is: equal where nodes of any tapes are the same one

  const Node& at(int i) const { return formulas->nodes[i]; }

  void place(Arena& arena, const BranchTape& tape, const double* parameters) {
    formulas = &tape;
    const int n = tape.count;
    int pieces = 0;
    node = arena.take<NodeFacts<T>>(n);
    inner = arena.take<Instruction<T>>(2 * n);
    outer = arena.take<Instruction<T>>(3 * n);
    wanted = arena.take<bool>(n);
    marks = arena.take<bool>(n);
    ranges = arena.take<Range>(n);
    reals = arena.take<Real<T>>(n);
    slopes = arena.take<Dual<4>>(n);
    numbers = arena.take<T>(n);
    key = arena.take<std::uint64_t>(n);
    for (int i = 0; i < n; ++i) {
      const Node& one = tape.nodes[i];
      if (is_piecewise(one.op)) ++pieces;
      const int p = whole_exponent(tape, one, parameters);
      const bool special = one.op >= Op::exponential || one.op == Op::power || one.op == Op::divide;
      T* own = arena.take<T>(series_size);
      T* aux = special ? arena.take<T>(series_size * (p > 0 ? 2 * squarings(p) : aux_series)) : nullptr;
      Crossings<T>* crossings = is_piecewise(one.op) ? arena.take<Crossings<T>>(1) : nullptr;
      if (arena.base == nullptr) continue;
      if (crossings != nullptr) *crossings = {};
      node[i].crossings = crossings;
      node[i].own = own;
      node[i].aux = aux;
      node[i].side = 0;
      if (one.op == Op::power || one.op == Op::square_root) aux[p > 0 ? 0 : largest_base] = T(0.0);
    }
    surfaces = arena.take<int>(pieces);
    surface_series = arena.take<T>(pieces * series_size);
  }
};

// The keys of a tape's nodes; what it reads of its own (u, v, dwell, states) is told from that of others by `owner`.
template <class T>
void set_keys(Tape<T>& tape, int owner) {
  const auto mixed = [](std::uint64_t a, std::uint64_t b) {  // splitmix64 of a pair
    std::uint64_t x = a * 0x9E3779B97F4A7C15ULL + b + 0xD1B54A32D192ED03ULL;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
    return x ^ (x >> 31);
  };
  const auto pair = [&](Op op, std::uint64_t a, std::uint64_t b) {
    return mixed(mixed(static_cast<std::uint64_t>(op) + 1, a), b);
  };
  for (int i = 0; i < tape.formulas->count; ++i) {
    const Node& one = tape.at(i);
    const bool own = one.op == Op::u || one.op == Op::v || one.op == Op::dwell || one.op == Op::state;
    if (is_leaf(one.op)) {
      tape.key[i] = pair(one.op, static_cast<std::uint64_t>(one.a), own ? static_cast<std::uint64_t>(owner) + 1 : 0);
    } else {
      tape.key[i] = pair(one.op, tape.key[one.a], is_binary(one.op) ? tape.key[one.b] : 0);
    }
  }
}

// Sides that were kept from an earlier visit are forgotten: the state decides anew.
template <class T>
void forget_sides(Tape<T>& tape) {
  for (int i = 0; i < tape.formulas->count; ++i) tape.node[i].side = 0;
}

// The same of surfaces that hang on v, and of those that were not watched. On a surface of anything else, the state does
// not tell which side the trajectory comes from.
template <class T>
void forget_sides_of_slip(Tape<T>& tape) {
  for (int i = 0; i < tape.formulas->count; ++i) {
    const Node& one = tape.at(i);
    tape.marks[i] = one.op == Op::u || one.op == Op::v ||
                    (!is_leaf(one.op) && (tape.marks[one.a] || (is_binary(one.op) && tape.marks[one.b])));
    if (tape.marks[i] || !tape.wanted[i]) tape.node[i].side = 0;
  }
}

}  // namespace stickslip::inline STICKSLIP_ISA
