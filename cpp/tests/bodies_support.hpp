// Rigs of bodies for the tests of the core, in any number type.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "stickslip/bodies/machine.hpp"
#include "support.hpp"

namespace support {

// Nodes of a tape as they are written down.
struct Sheet {
  std::vector<Node> nodes;
  int put(Op op, int a = 0, int b = 0) {
    nodes.push_back({op, a, b});
    return static_cast<int>(nodes.size()) - 1;
  }
  BranchTape view(int force, int limit = -1, const int* rates = nullptr) const {
    return {nodes.data(), static_cast<int>(nodes.size()), force, limit, rates};
  }
};

template <class T>
struct BodiesChange {
  T t;
  std::vector<int> after;
  std::vector<T> z;
};
template <class T>
struct BodiesRun {
  std::vector<BodiesChange<T>> changes;
  std::vector<T> end;
  Summary summary;
};

// `vary(values)` moves or seeds the numbers of the layout.
template <class T, class Vary>
BodiesRun<T> run_bodies(const Bodies& bodies, const std::vector<double>& values, double t_end, double tolerance,
                        const Vary& vary) {
  Arena count;
  BodiesSystem<T> sys;
  const auto lay_out = [&](Arena& arena) {
    sys.place(arena, bodies, values.data());
    const Options options{tolerance, tolerance, t_end, true, order_for(tolerance_share * tolerance), 0.0, 100000};
    BodiesMachine<T> machine(sys, options);
    machine.place(arena);
    return machine;
  };
  lay_out(count);
  const std::unique_ptr<void, decltype(&std::free)> memory(std::aligned_alloc(64, (count.used + 63) / 64 * 64),
                                                           std::free);
  Arena arena{static_cast<std::byte*>(memory.get()), 0};
  std::memset(memory.get(), 0xFF, count.used);  // not numbers: what is read before it is written shows
  BodiesMachine<T> machine = lay_out(arena);
  for (auto& t : machine.chatter.recent) t = 1e300;
  for (int i = 0; i < sys.at.size; ++i) sys.values[i] = T(values[static_cast<std::size_t>(i)]);
  vary(sys.values);
  build(sys);
  const std::vector<signed char> modes(static_cast<std::size_t>(bodies.contacts), 2);
  machine.start(0.0, modes.data());
  BodiesRun<T> out;
  const auto state = [&] { return std::vector<T>(machine.s.z, machine.s.z + sys.at.state); };
  const auto changed = [&](BodiesMachine<T>& m, bool kink) {
    if (kink) return;
    BodiesChange<T> c{m.s.t, {}, state()};
    for (int j = 0; j < sys.contacts; ++j) c.after.push_back(sys.contact[j].mode);
    out.changes.push_back(c);
  };
  machine.run([](const auto&...) {}, changed, [](auto&) {}, [] { return false; });
  out.end = state();
  out.summary = machine.summary;
  return out;
}

}  // namespace support
