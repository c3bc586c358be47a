// One trajectory of a rig of bodies, compiled once per instruction set.
#include "stickslip/bodies/kernel.hpp"

#include "stickslip/bodies/machine.hpp"
#include "stickslip/bodies/totals.hpp"
#include "stickslip/single_run.hpp"

namespace stickslip::inline STICKSLIP_ISA {

namespace {

template <class T>
struct BodiesWriter {
  const BodiesRequest& request;
  const BodiesSink& sink;
  int numbers;  // of the state
  int senses = 0;
  long next = 0;
  T* row = nullptr;
  T begun{};           // when the piece began whose series stand
  int used = 1;        // their order
  bool turned = true;  // they were begun anew, to first order, where the state is
  double *values = nullptr, *derivatives = nullptr;
  signed char* modes = nullptr;

  void place(Arena& arena) {
    senses = request.sensed ? sensed_count(*request.bodies) : 0;
    row = arena.take<T>(numbers + senses + 1);
    values = arena.take<double>(numbers + senses + 1);
    derivatives = arena.take<double>((numbers + senses + 1) * 12);
    modes = arena.take<signed char>(request.bodies->contacts);
  }
  void set_modes(const BodiesSystem<T>& sys) {
    for (int j = 0; j < sys.contacts; ++j) modes[j] = sys.contact[j].mode;
  }
  // The state in `row`, h after the start of the piece whose series stand.
  void emit(const BodiesSystem<T>& sys, const T& h, int order, double t) {
    if (senses > 0) sense(sys, h, order, row, row + numbers);
    unpack(row, numbers + senses, request.n_seeds, values, derivatives);
    set_modes(sys);
    sink.sample(sink.context, t, values, derivatives, modes);
  }
  void emit_state(const BodiesMachine<T>& machine, double t) {
    for (int i = 0; i < numbers; ++i) row[i] = machine.s.z[i];
    emit(machine.sys, turned ? T(0.0) : machine.s.t - begun, used, t);
  }
  void step(BodiesMachine<T>& machine, Real<T> h, int order, bool inclusive) {
    begun = machine.s.t;
    used = order == 0 ? 1 : order;  // a long stretch: what is not constant is linear in t
    turned = false;
    if (request.t_eval == nullptr || order == 0) return;
    const Real<T> t1 = value(machine.s.t) + h;
    for (; next < request.n_eval; ++next) {
      const Real<T> t = machine.asked = request.t_eval[next];
      if (!(t < t1 || (inclusive && t <= t1))) return;
      const T since = T(t) - machine.s.t;
      machine.state_at(since, order, row);
      emit(machine.sys, since, order, request.t_eval[next]);
    }
    machine.asked = std::numeric_limits<double>::infinity();
  }
  void changed(BodiesMachine<T>& machine, bool kink) {
    turned = true;
    used = 1;
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
  constexpr bool sums = std::is_same_v<T, double>;
  BodiesTally tally{q.totals};
  if constexpr (sums) tally.place(arena, sys);
  if (memory == nullptr) return arena.used;
  load(q.values, q.seeds, 0, q.n_seeds, sys.at.size, sys.values, sys.at.size);
  build(sys);
  machine.start(q.t_start, q.modes);
  if (q.t_eval == nullptr) writer.emit_state(machine, q.t_start);
  if constexpr (sums) {
    tally.clear(sys);
    if (tally.any()) machine.seen_from = q.totals.after;
  }
  const auto observe = [&](BodiesMachine<T>& m, Real<T> h, int used, bool inclusive) {
    if constexpr (sums) tally.step(m, h, used);
    writer.step(m, h, used, inclusive);
  };
  const auto changed = [&](BodiesMachine<T>& m, bool kink) { writer.changed(m, kink); };
  const auto stepped = [&](BodiesMachine<T>& m) {
    if (q.t_eval == nullptr) writer.emit_state(m, static_cast<double>(value(m.s.t)));
  };
  machine.run(observe, changed, stepped, [&] { return sink->interrupted(sink->context); });
  if (q.t_eval != nullptr && machine.summary.outcome == Outcome::finished)  // where the run ends on a transition
    for (; writer.next < q.n_eval; ++writer.next) writer.emit_state(machine, q.t_eval[writer.next]);
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
