// One trajectory of a rig of bodies, compiled once per instruction set.
#include "stickslip/bodies/kernel.hpp"

#include "stickslip/bodies/machine.hpp"
#include "stickslip/single_run.hpp"

namespace stickslip::inline STICKSLIP_ISA {

namespace {

template <class T>
struct BodiesWriter {
  const BodiesRequest& request;
  const BodiesSink& sink;
  int numbers;
  long next = 0;
  T* row = nullptr;
  double *values = nullptr, *derivatives = nullptr;
  signed char* modes = nullptr;

  void place(Arena& arena) {
    row = arena.take<T>(numbers + 1);
    values = arena.take<double>(numbers + 1);
    derivatives = arena.take<double>((numbers + 1) * 12);
    modes = arena.take<signed char>(request.bodies->contacts);
  }
  void set_modes(const BodiesSystem<T>& sys) {
    for (int j = 0; j < sys.contacts; ++j) modes[j] = sys.contact[j].mode;
  }
  void emit(const BodiesSystem<T>& sys, const T* z, double t) {
    unpack(z, numbers, request.n_seeds, values, derivatives);
    set_modes(sys);
    sink.sample(sink.context, t, values, derivatives, modes);
  }
  void step(BodiesMachine<T>& machine, Real<T> h, int order, bool inclusive) {
    if (request.t_eval == nullptr || order == 0) return;
    const Real<T> t1 = value(machine.s.t) + h;
    for (; next < request.n_eval; ++next) {
      const Real<T> t = machine.asked = request.t_eval[next];
      if (!(t < t1 || (inclusive && t <= t1))) return;
      machine.state_at(T(t) - machine.s.t, order, row);
      emit(machine.sys, row, request.t_eval[next]);
    }
    machine.asked = std::numeric_limits<double>::infinity();
  }
  void changed(BodiesMachine<T>& machine, bool kink) {
    row[0] = machine.s.t;
    for (int i = 0; i < numbers; ++i) row[i + 1] = machine.s.z[i];
    unpack(row, numbers + 1, request.n_seeds, values, derivatives);
    set_modes(machine.sys);
    sink.transition(sink.context, {values[0], machine.before, modes, kink, values + 1, derivatives});
  }
};

template <class T>
std::size_t run_as(const BodiesRequest& q, const BodiesSink* sink, Summary* summary, void* memory) {
  Arena arena{static_cast<std::byte*>(memory), 0};
  BodiesSystem<T> sys;
  sys.place(arena, *q.bodies, q.values);
  const Options options = options_alone(q, 0, 0.0);
  BodiesMachine<T> machine(sys, options);
  machine.place(arena);
  static constexpr BodiesSink nowhere{};
  BodiesWriter<T> writer{q, sink == nullptr ? nowhere : *sink, sys.at.state};
  writer.place(arena);
  if (memory == nullptr) return arena.used;
  load(q.values, q.seeds, 0, q.n_seeds, sys.at.size, sys.values, sys.at.size);
  build(sys);
  machine.start(q.t_start, q.modes);
  if (q.t_eval == nullptr) writer.emit(sys, machine.s.z, q.t_start);
  const auto observe = [&](BodiesMachine<T>& m, Real<T> h, int used, bool inclusive) {
    writer.step(m, h, used, inclusive);
  };
  const auto changed = [&](BodiesMachine<T>& m, bool kink) { writer.changed(m, kink); };
  const auto stepped = [&](BodiesMachine<T>& m) {
    if (q.t_eval == nullptr) writer.emit(sys, m.s.z, static_cast<double>(value(m.s.t)));
  };
  machine.run(observe, changed, stepped, [&] { return sink->interrupted(sink->context); });
  if (q.t_eval != nullptr && machine.summary.outcome == Outcome::finished)  // where the run ends on a transition
    for (; writer.next < q.n_eval; ++writer.next) writer.emit(sys, machine.s.z, q.t_eval[writer.next]);
  *summary = machine.summary;
  return arena.used;
}

std::size_t run(const BodiesRequest& q, const BodiesSink* sink, Summary* summary, void* memory) {
  if (q.n_seeds == 0) return run_as<double>(q, sink, summary, memory);
  if (q.n_seeds <= 4) return run_as<Dual<4>>(q, sink, summary, memory);
  return run_as<Dual<12>>(q, sink, summary, memory);
}

}  // namespace

std::size_t bodies_workspace(const BodiesRequest& q) { return run(q, nullptr, nullptr, nullptr); }
void simulate_bodies(const BodiesRequest& q, const BodiesSink& sink, Summary& summary, void* workspace) {
  run(q, &sink, &summary, workspace);
}

}  // namespace stickslip::inline STICKSLIP_ISA
