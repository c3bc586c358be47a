// The instruction sets the kernel is compiled for, and the choice among them at run time.
#pragma once

#include <array>
#include <string_view>

// The namespace of one compilation of the kernel and of every template it instantiates: baseline in
// all ordinary translation units, avx2 or avx512 where the build says so. Different names, so the
// linker cannot merge an inline function compiled for one machine into code that runs on another.
#ifndef STICKSLIP_ISA
#define STICKSLIP_ISA baseline
#endif
#ifndef STICKSLIP_LANES
#define STICKSLIP_LANES 2
#endif

namespace stickslip {

enum class Isa { baseline, avx2, avx512 };

struct IsaFacts {
  Isa isa;
  std::string_view name;   // as in STICKSLIP_ISA and in the environment variable of the same name
  std::string_view march;  // the psABI level it is compiled for on x86-64
  int lanes;               // doubles in one register
};

inline constexpr std::array<IsaFacts, 3> isa_facts{{{Isa::baseline, "baseline", "x86-64-v2", 2},
                                                    {Isa::avx2, "avx2", "x86-64-v3", 4},
                                                    {Isa::avx512, "avx512", "x86-64-v4", 8}}};

constexpr const IsaFacts& facts(Isa isa) { return isa_facts.at(static_cast<std::size_t>(isa)); }

// Was the kernel compiled for `isa`, and does this processor have it?
bool is_compiled(Isa isa) noexcept;
bool is_supported(Isa isa) noexcept;

// The widest set that is compiled and supported; the environment variable STICKSLIP_ISA, read once,
// asks for a narrower one by name. A name it cannot serve is ignored.
Isa isa_in_use() noexcept;

}  // namespace stickslip
