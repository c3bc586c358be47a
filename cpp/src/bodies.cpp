#include "stickslip/bodies/record.hpp"

#include <memory>

#include "stickslip/bodies/kernel.hpp"
#include "stickslip/collector.hpp"
#include "stickslip/kernel.hpp"

namespace stickslip {

using Workspace = std::size_t(const stickslip_abi::BodiesRequest&);
using Simulate = void(const stickslip_abi::BodiesRequest&, const stickslip_abi::BodiesSink&, stickslip_abi::Summary&,
                      void*);
#ifdef STICKSLIP_HAS_AVX2
namespace avx2 {
Workspace bodies_workspace;
Simulate simulate_bodies;
}  // namespace avx2
#endif
#ifdef STICKSLIP_HAS_AVX512
namespace avx512 {
Workspace bodies_workspace;
Simulate simulate_bodies;
}  // namespace avx512
#endif

namespace dispatch {

std::size_t bodies_workspace(const stickslip_abi::BodiesRequest& q) {
  switch (isa_in_use()) {
#ifdef STICKSLIP_HAS_AVX512
    case Isa::avx512: return avx512::bodies_workspace(q);
#endif
#ifdef STICKSLIP_HAS_AVX2
    case Isa::avx2: return avx2::bodies_workspace(q);
#endif
    default: return baseline::bodies_workspace(q);
  }
}
void simulate_bodies(const stickslip_abi::BodiesRequest& q, const stickslip_abi::BodiesSink& sink,
                     stickslip_abi::Summary& summary, void* workspace) {
  switch (isa_in_use()) {
#ifdef STICKSLIP_HAS_AVX512
    case Isa::avx512: return avx512::simulate_bodies(q, sink, summary, workspace);
#endif
#ifdef STICKSLIP_HAS_AVX2
    case Isa::avx2: return avx2::simulate_bodies(q, sink, summary, workspace);
#endif
    default: return baseline::simulate_bodies(q, sink, summary, workspace);
  }
}

}  // namespace dispatch

namespace {

using namespace stickslip_abi;

using Rows = Collector<BodiesRecord>;

void on_sample(void* context, double t, const double* state, const double* derivatives, const signed char* modes) {
  Rows& c = *static_cast<Rows*>(context);
  BodiesRecord& out = *c.out;
  if (c.merge && c.row > 0 && t == c.last) {
    --c.row;
    if (c.first == 0) {
      out.t.pop_back();
      out.state.resize(out.state.size() - out.states);
      out.sensed.resize(out.sensed.size() - out.senses);
      out.mode.resize(out.mode.size() - out.contacts);
    }
  }
  c.last = t;
  if (c.first == 0) {
    out.t.push_back(t);
    out.state.insert(out.state.end(), state, state + out.states);
    out.sensed.insert(out.sensed.end(), state + out.states, state + out.states + out.senses);
    out.mode.insert(out.mode.end(), modes, modes + out.contacts);
  }
  if (out.senses > 0) c.place(out.sensed_sensitivity, c.row, out.senses, derivatives + out.states * c.count);
  c.place(out.sensitivity, c.row++, out.states, derivatives);
}

void on_transition(void* context, const BodiesTransition& event) {
  Rows& c = *static_cast<Rows*>(context);
  BodiesRecord& out = *c.out;
  if (event.kink) {
    if (c.first == 0) out.kink_t.push_back(event.t);
    return;
  }
  if (c.first == 0) {
    out.event_t.push_back(event.t);
    out.event_state.insert(out.event_state.end(), event.state, event.state + out.states);
    out.event_before.insert(out.event_before.end(), event.before, event.before + out.contacts);
    out.event_after.insert(out.event_after.end(), event.after, event.after + out.contacts);
  }
  c.place(out.event_sensitivity, c.event_row++, 1 + out.states, event.derivatives);
}

}  // namespace

BodiesRecord record_bodies(const BodiesRequest& request, const Summed& summed, bool (*interrupted)(void*)) {
  BodiesRecord out;
  const auto twice = static_cast<std::size_t>(summed.extremes ? 2 * request.bodies->n : 0);
  out.low.resize(twice);
  out.high.resize(twice);
  out.work.resize(static_cast<std::size_t>(summed.work ? request.bodies->contacts : 0));
  const auto room = [](std::vector<double>& of) { return of.empty() ? nullptr : of.data(); };
  const BodiesTotals totals{summed.after, room(out.low), room(out.high), room(out.work)};
  const BodiesLayout at = layout_of(*request.bodies);
  out.seeds = static_cast<std::size_t>(request.n_seeds);
  out.states = static_cast<std::size_t>(at.state);
  out.contacts = static_cast<std::size_t>(request.bodies->contacts);
  out.senses = request.sensed ? static_cast<std::size_t>(sensed_count(*request.bodies)) : 0;
  for (int group = 0; group < dispatch::seed_groups(request.n_seeds); ++group) {
    const auto [first, count] = dispatch::seed_group(request.n_seeds, group);
    BodiesRequest part = request;
    part.n_seeds = count;
    part.totals = totals;
    if (request.n_seeds > 0) part.seeds = request.seeds + static_cast<std::ptrdiff_t>(first) * at.size;
    Rows collector{&out, static_cast<std::size_t>(first), static_cast<std::size_t>(count), request.t_eval == nullptr};
    const BodiesSink sink{&collector, on_sample, on_transition, interrupted};
    constexpr std::size_t line = 64;
    std::vector<std::byte> memory(dispatch::bodies_workspace(part) + line);
    void* workspace = memory.data();
    std::size_t left = memory.size();
    std::align(line, left - line, workspace, left);
    dispatch::simulate_bodies(part, sink, out.summary, workspace);
    if (out.summary.outcome == Outcome::interrupted) break;
  }
  return out;
}

}  // namespace stickslip
