#include "stickslip/record.hpp"

#include "stickslip/collector.hpp"
#include "stickslip/kernel.hpp"

namespace stickslip {

namespace {

using namespace stickslip_abi;

using Rows = Collector<Record>;

void on_sample(void* context, double t, const double* state, const double* derivatives, int mode) {
  Rows& c = *static_cast<Rows*>(context);
  if (c.merge && c.row > 0 && t == c.last) {
    --c.row;
    if (c.first == 0) {
      c.out->t.pop_back();
      c.out->state.resize(c.out->state.size() - state_count);
      c.out->mode.pop_back();
    }
  }
  c.last = t;
  if (c.first == 0) {
    c.out->t.push_back(t);
    c.out->state.insert(c.out->state.end(), state, state + state_count);
    c.out->mode.push_back(static_cast<signed char>(mode));
  }
  c.place(c.out->sensitivity, c.row++, state_count, derivatives);
}

void on_transition(void* context, const Transition& event) {
  Rows& c = *static_cast<Rows*>(context);
  if (event.kink) {
    if (c.first == 0) c.out->kink_t.push_back(event.t);
    return;
  }
  if (c.first == 0) {
    c.out->event_t.push_back(event.t);
    c.out->event_state.insert(c.out->event_state.end(), event.state, event.state + state_count);
    c.out->event_before.push_back(static_cast<signed char>(event.before));
    c.out->event_after.push_back(static_cast<signed char>(event.after));
  }
  c.place(c.out->event_sensitivity, c.event_row++, 1 + state_count, event.derivatives);
}

}  // namespace

Record record(const Request& request, bool (*interrupted)(void*)) {
  Record out;
  out.seeds = static_cast<std::size_t>(request.n_seeds);
  if (request.t_eval != nullptr) {
    out.t.reserve(static_cast<std::size_t>(request.n_eval));
    out.state.reserve(static_cast<std::size_t>(request.n_eval) * state_count);
    out.sensitivity.reserve(out.state.capacity() * out.seeds);  // growing would hold three times as much
  }
  constexpr int row = parameter_count + state_count;
  for (int group = 0; group < dispatch::seed_groups(request.n_seeds); ++group) {
    const auto [first, count] = dispatch::seed_group(request.n_seeds, group);
    Request part = request;
    part.n_seeds = count;
    if (request.n_seeds > 0) part.seeds = request.seeds + static_cast<std::ptrdiff_t>(first) * row;
    Rows collector{&out, static_cast<std::size_t>(first), static_cast<std::size_t>(count), request.t_eval == nullptr};
    const Sink sink{&collector, on_sample, on_transition, interrupted};
    dispatch::simulate(part, sink, out.summary);
    if (out.summary.outcome == Outcome::interrupted) break;
  }
  return out;
}

}  // namespace stickslip
