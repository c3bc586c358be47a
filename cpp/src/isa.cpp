#include "stickslip/isa.hpp"

#include <cstdlib>

namespace stickslip {

bool is_compiled(Isa isa) noexcept {
  switch (isa) {
    case Isa::baseline: return true;
    case Isa::avx2:
#ifdef STICKSLIP_HAS_AVX2
      return true;
#else
      return false;
#endif
    case Isa::avx512:
#ifdef STICKSLIP_HAS_AVX512
      return true;
#else
      return false;
#endif
  }
  return false;
}

bool is_supported(Isa isa) noexcept {
#if defined(__x86_64__)
  // Feature by feature what the psABI levels v3 and v4 promise to the compiler.
  __builtin_cpu_init();
  const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
                  __builtin_cpu_supports("bmi2");
  const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                  __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512vl");
  return isa == Isa::baseline || (isa == Isa::avx2 && v3) || (isa == Isa::avx512 && v4);
#else
  return isa == Isa::baseline;
#endif
}

namespace {

Isa choose() noexcept {
  const char* asked = std::getenv("STICKSLIP_ISA");
  Isa best = Isa::baseline;
  for (const IsaFacts& candidate : isa_facts) {
    if (!is_compiled(candidate.isa) || !is_supported(candidate.isa)) continue;
    best = candidate.isa;
    if (asked != nullptr && candidate.name == asked) break;
  }
  return best;
}

}  // namespace

Isa isa_in_use() noexcept {
  static const Isa isa = choose();
  return isa;
}

}  // namespace stickslip
