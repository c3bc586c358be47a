// One trajectory, compiled once per instruction set (cmake/stickslip.cmake) in the namespace stickslip::STICKSLIP_ISA.
#include "stickslip/kernel.hpp"

#include "stickslip/single_run.hpp"
#include "stickslip/table.hpp"

namespace stickslip::inline STICKSLIP_ISA {

namespace {

template <class T>
struct Writer {
  const Request& request;
  const Sink& sink;
  int seeds;
  long next = 0;
  double values[state_count + 1] = {};
  double derivatives[(state_count + 1) * 12] = {};

  Writer(const Request& q, const Sink& out, int n) : request(q), sink(out), seeds(n) {}
  void emit(const T* z, double t, int contact) {
    unpack(z, state_count, seeds, values, derivatives);
    sink.sample(sink.context, t, values, derivatives, contact);
  }
  // What is left where the run ends on a transition.
  template <class M>
  void finish(M& machine) {
    if (request.t_eval == nullptr || machine.summary.outcome != Outcome::finished) return;
    for (; next < request.n_eval; ++next) emit(machine.s.z, request.t_eval[next], machine.mode.contact);
  }
  // Samples at t in [start, start + h); `inclusive` takes the right end too.
  template <class M>
  void step(M& machine, Real<T> h, int order, bool inclusive) {
    if (request.t_eval == nullptr || order == 0) return;
    const Real<T> t0 = value(machine.s.t), t1 = t0 + h;
    for (; next < request.n_eval; ++next) {
      const Real<T> t = machine.asked = request.t_eval[next];
      if (!(t < t1 || (inclusive && t <= t1))) return;
      T z[state_count];
      machine.state_at(T(t) - machine.s.t, order, z, request.plain);
      emit(z, request.t_eval[next], machine.mode.contact);
    }
    machine.asked = std::numeric_limits<double>::infinity();
  }
};

template <class T>
void prepare(const Request& q, System<T>& sys, State<T>& s, int first, int count) {
  const int stride = parameter_count + state_count;
  sys.structure = *q.structure;
  load(q.parameters, q.seeds, first, count, stride, sys.p.p, parameter_count);
  const double* seeds = q.seeds == nullptr ? nullptr : q.seeds + parameter_count;
  load(q.initial, seeds, first, count, stride, s.z, state_count);
  s.t = T(q.t_start);
  build(sys);
  build_tables(sys);
}

template <class T>
void run_as(const Request& q, const Sink& sink, Summary& summary, int first, int count) {
  System<T> sys;
  State<T> s;
  prepare(q, sys, s, first, count);
  const Options options = options_alone(q, q.order, q.fixed_step);
  Machine<T> machine(sys, options);
  machine.start(s, q.contact);
  Writer<T> writer(q, sink, count);
  if (q.t_eval == nullptr) writer.emit(machine.s.z, q.t_start, machine.mode.contact);
  const auto observe = [&](Machine<T>& m, Real<T> h, int order, bool inclusive) {
    writer.step(m, h, order, inclusive);
  };
  const auto changed = [&](Machine<T>& m, const Mode& before, bool kink) {
    T row[state_count + 1];
    row[0] = m.s.t;
    for (int i = 0; i < state_count; ++i) row[i + 1] = m.s.z[i];
    unpack(row, state_count + 1, count, writer.values, writer.derivatives);
    sink.transition(sink.context,
                    {writer.values[0], before.contact, m.mode.contact, kink, writer.values + 1, writer.derivatives});
  };
  const auto stepped = [&](Machine<T>& m) {
    if (q.t_eval == nullptr) writer.emit(m.s.z, static_cast<double>(value(m.s.t)), m.mode.contact);
  };
  machine.run(observe, changed, stepped, [&] { return sink.interrupted(sink.context); });
  writer.finish(machine);
  summary = machine.summary;
}

}  // namespace

void simulate(const Request& q, const Sink& sink, Summary& summary) {
  if (q.n_seeds == 0) return run_as<double>(q, sink, summary, 0, 0);
  if (q.n_seeds <= 4) return run_as<Dual<4>>(q, sink, summary, 0, q.n_seeds);
  if (q.n_seeds <= 8) return run_as<Dual<8>>(q, sink, summary, 0, q.n_seeds);
  run_as<Dual<12>>(q, sink, summary, 0, q.n_seeds);
}

}  // namespace stickslip::inline STICKSLIP_ISA
