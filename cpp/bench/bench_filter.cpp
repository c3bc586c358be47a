// The scan of (3.1) beside the plain loop, for one and for eight channels; the answers are compared first.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "stickslip/filter.hpp"

namespace {

constexpr std::size_t samples = 100'000;
constexpr stickslip::Recursion constants{0.9, 100.0, -100.0};

std::vector<double> waves(std::size_t size) {
  std::vector<double> x(size);
  for (std::size_t i = 0; i < size; ++i) x[i] = std::sin(1e-3 * static_cast<double>(i));
  return x;
}

void plain(benchmark::State& state) {
  const auto channels = static_cast<std::size_t>(state.range(0));
  const std::vector<double> x = waves(samples * channels);
  std::vector<double> y(x.size());
  for ([[maybe_unused]] auto _ : state) {
    stickslip::first_order_plain(x.data(), y.data(), samples, channels, constants);
    benchmark::DoNotOptimize(y.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(x.size()));
}

void scan(benchmark::State& state) {
  const auto channels = static_cast<std::size_t>(state.range(0));
  const std::vector<double> x = waves(samples * channels);
  std::vector<double> y(x.size());
  std::vector<double> expected(x.size());
  stickslip::first_order_plain(x.data(), expected.data(), samples, channels, constants);
  for ([[maybe_unused]] auto _ : state) {
    if (!stickslip::first_order(x.data(), y.data(), samples, channels, constants)) state.SkipWithError("not finite");
    benchmark::DoNotOptimize(y.data());
    benchmark::ClobberMemory();
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (std::abs(y[i] - expected[i]) > 1e-10) state.SkipWithError("the scan differs from the plain loop");
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(x.size()));
}

BENCHMARK(plain)->Arg(1)->Arg(8);
BENCHMARK(scan)->Arg(1)->Arg(8);

}  // namespace

BENCHMARK_MAIN();
