// Laws and speeds as tapes that own their nodes, checked once, and what a request points into.
#pragma once

#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "pybind.hpp"
#include "stickslip/bodies/interface.hpp"

namespace stickslip::bindings {

using namespace stickslip_abi;  // NOLINT(google-build-using-namespace): plain data shared by every build

constexpr int most_coordinates = 64, most_contacts = 64, most_pushes = 64;
inline constexpr std::array<std::string_view, static_cast<std::size_t>(Op::count)> op_names{
    "parameter", "u",        "v",          "t",   "dwell",    "state",    "coordinate",
    "velocity",  "distance", "prescribed", "add", "subtract", "multiply", "divide",
    "power",     "negate",   "abs",        "min", "max",      "sign",     "exp",
    "log",       "sqrt",     "sin",        "cos", "tan",      "tanh",     "asinh"};

using Rows = std::vector<std::array<int, 3>>;

// A tape that owns its nodes.
struct Formulas {
  std::vector<Node> nodes;
  std::vector<int> rates;
  int force, limit;

  Formulas(const Rows& rows, int out, int static_limit, std::vector<int> state_rates)
      : rates(std::move(state_rates)), force(out), limit(static_limit) {
    for (const auto& [op, a, b] : rows) {
      const int i = static_cast<int>(nodes.size());
      if (op < 0 || op >= static_cast<int>(Op::count)) throw py::value_error("unknown operation");
      const Node node{static_cast<Op>(op), a, b};
      const bool binary =
          (node.op >= Op::add && node.op <= Op::power) || node.op == Op::minimum || node.op == Op::maximum;
      if (node.op > Op::prescribed && (a < 0 || a >= i || (binary && (b < 0 || b >= i))))
        throw py::value_error("a node must read nodes before it");
      if ((node.op == Op::parameter || (node.op >= Op::state && node.op <= Op::prescribed)) && a < 0)
        throw py::value_error("a place must not be negative");
      nodes.push_back(node);
    }
    const int n = static_cast<int>(nodes.size());
    for (const int r : rates)
      if (r < 0 || r >= n) throw py::value_error("a rate is no node");
    if (force < 0 || force >= n || limit < -1 || limit >= n) throw py::value_error("force or limit is no node");
    if (rates.size() > most_law_states) throw py::value_error("a law has at most 16 states");
  }
  BranchTape view() const { return {nodes.data(), static_cast<int>(nodes.size()), force, limit, rates.data()}; }
  int largest(Op op) const {
    int top = -1;
    for (const Node& one : nodes)
      if (one.op == op) top = std::max(top, one.a);
    return top;
  }
};

// Nodes read what a rig of n coordinates and some speeds has.
inline bool reads_rig(const Formulas& one, int parameters, int states, int n, int speeds) {
  return one.largest(Op::parameter) < parameters && one.largest(Op::state) < states &&
         one.largest(Op::coordinate) < n && one.largest(Op::velocity) < n && one.largest(Op::distance) < speeds &&
         one.largest(Op::prescribed) < speeds;
}

struct Speed {
  std::vector<double> begins;
  std::vector<Formulas> pieces;
};

// Everything that a request points into.
struct Model {
  std::vector<LawTape> laws;
  std::vector<PushTape> pushes;
  std::vector<std::vector<BranchTape>> pieces;
  std::vector<SpeedTape> speeds;
  Bodies bodies{};
};

inline void check(bool good, const char* words) {
  if (!good) throw py::value_error(words);
}

inline Model model_of(int n, const std::vector<std::pair<Formulas, Formulas>>& laws, const IndexVector& contact_speed,
                      const std::vector<Speed>& speeds, const std::vector<Formulas>& pushes, int parameters) {
  Model m;
  check(n >= 1 && n <= most_coordinates && laws.size() <= most_contacts, "1 to 64 coordinates, at most 64 contacts");
  int states = 0;
  for (const auto& [minus, plus] : laws) {
    check(minus.rates.size() == plus.rates.size() && (minus.limit < 0) == (plus.limit < 0),
          "both directions of a law have the same states, and stick or do not");
    for (const Formulas* one : {&minus, &plus})
      check(reads_rig(*one, parameters, static_cast<int>(one->rates.size()), n, static_cast<int>(speeds.size())),
            "a law reads what is not there");
    m.laws.push_back({{minus.view(), plus.view()}, static_cast<int>(minus.rates.size())});
    states += static_cast<int>(minus.rates.size());
  }
  check(pushes.size() <= most_pushes, "at most 64 pushes");
  for (const Formulas& one : pushes) {
    const int own = static_cast<int>(one.rates.size());
    check(reads_rig(one, parameters, own, n, static_cast<int>(speeds.size())), "a push reads what is not there");
    for (const Node& node : one.nodes)
      check(node.op != Op::u && node.op != Op::v && node.op != Op::dwell, "a push reads no u, v or dwell");
    m.pushes.push_back({one.view(), own});
    states += own;
  }
  for (const Speed& one : speeds) {
    std::vector<BranchTape> pieces;
    for (const Formulas& piece : one.pieces) {
      check(piece.largest(Op::parameter) < parameters, "a speed reads a parameter that is not there");
      for (const Node& node : piece.nodes)
        check(node.op != Op::u && node.op != Op::v && node.op != Op::dwell &&
                  (node.op < Op::state || node.op > Op::prescribed) && node.op != Op::sign && node.op != Op::absolute &&
                  node.op != Op::minimum && node.op != Op::maximum,
              "a speed is a formula of t without abs, sign, min, max; give it in pieces");
      pieces.push_back(piece.view());
    }
    m.pieces.push_back(std::move(pieces));
  }
  for (std::size_t i = 0; i < speeds.size(); ++i)
    m.speeds.push_back({speeds[i].begins.data(), m.pieces[i].data(), static_cast<int>(m.pieces[i].size())});
  for (const int one : contact_speed) check(one >= -1 && one < static_cast<int>(speeds.size()), "no such speed");
  m.bodies = {n,
              static_cast<int>(laws.size()),
              static_cast<int>(speeds.size()),
              parameters,
              states,
              m.laws.data(),
              contact_speed.data(),
              m.speeds.data(),
              static_cast<int>(m.pushes.size()),
              m.pushes.data()};
  return m;
}

}  // namespace stickslip::bindings
