#include "stickslip/windows.hpp"

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "stickslip/kernel.hpp"

namespace stickslip {

namespace {

using namespace stickslip_abi;

struct Shared {
  const WindowsRequest& request;
  const WindowsResult& out;
  std::atomic<long> next{0};
  std::atomic<bool> stop{false};
};

// Where one group of seeds of one window writes.
struct Writer {
  const WindowsRequest& request;
  const WindowsResult& out;
  std::ptrdiff_t row;
  int first, count;
};

void on_sample(void* context, double, const double* state, const double* derivatives, int mode) {
  Writer& w = *static_cast<Writer*>(context);
  const WindowsRequest& q = w.request;
  if (w.first == 0) {
    std::copy_n(state, state_count, w.out.state + w.row * state_count);
    w.out.mode[w.row] = static_cast<signed char>(mode);
  }
  const std::ptrdiff_t samples = q.offset[q.windows];
  for (int i = 0; i < q.n_kept; ++i) {
    double* to = w.out.slopes + (i * samples + w.row) * q.columns;
    for (int k = 0; k < w.count; ++k) to[q.column[w.first + k]] = derivatives[q.kept[i] * w.count + k];
  }
  ++w.row;
}

void no_transition(void*, const Transition&) {}

void run_window(Shared& shared, long index, bool (*interrupted)(void*)) {
  const WindowsRequest& q = shared.request;
  constexpr int width = parameter_count + state_count;
  const long begin = q.offset[index], n = q.offset[index + 1] - begin;
  Request one{};
  one.structure = q.structures[q.set[index]];
  one.parameters = q.parameters + static_cast<std::ptrdiff_t>(q.set[index]) * parameter_count;
  one.initial = q.initial + index * state_count;
  one.t_start = q.t[begin];
  one.t_end = q.t[begin + n - 1];
  one.contact = q.contact[index];
  one.t_eval = q.t + begin;
  one.n_eval = n;
  one.rtol = q.rtol;
  one.atol = q.atol;
  one.locator = Locator::henon;
  one.max_transitions = q.max_transitions;
  one.max_steps = q.max_steps;
  one.order = q.order;
  one.plain = ~std::uint32_t{0};
  for (int i = 0; i < q.n_kept; ++i) one.plain &= ~(std::uint32_t{1} << q.kept[i]);
  Summary summary;
  for (int group = 0; group < dispatch::seed_groups(q.n_seeds); ++group) {
    const auto [first, count] = dispatch::seed_group(q.n_seeds, group);
    one.n_seeds = count;
    one.seeds = q.seeds + static_cast<std::ptrdiff_t>(first) * width;
    Writer writer{q, shared.out, begin, first, count};
    dispatch::simulate(one, {&writer, on_sample, no_transition, interrupted}, summary);
    if (summary.outcome != Outcome::finished) break;
  }
  if (summary.outcome == Outcome::interrupted) shared.stop = true;
  shared.out.outcome[index] = summary.outcome;
}

bool never(void*) { return false; }

void work(Shared& shared, bool (*interrupted)(void*)) {
  for (long i = shared.next++; i < shared.request.windows && !shared.stop; i = shared.next++)
    run_window(shared, i, interrupted);
}

}  // namespace

bool simulate_windows(const WindowsRequest& q, const WindowsResult& out, int threads, bool (*interrupted)(void*)) {
  const std::ptrdiff_t numbers = static_cast<std::ptrdiff_t>(q.offset[q.windows]) * q.columns * q.n_kept;
  if (q.n_seeds < q.columns) std::fill_n(out.slopes, numbers, 0.0);
  Shared shared{q, out};
  std::vector<std::thread> others;
  for (long i = 1; i < std::min<long>(threads, q.windows); ++i) others.emplace_back([&] { work(shared, never); });
  work(shared, interrupted);
  for (std::thread& one : others) one.join();
  return !shared.stop;
}

}  // namespace stickslip
