// Chooses the variant of (3.1) for the processor the program runs on.
#include "stickslip/filter.hpp"
#include "stickslip/isa.hpp"

namespace stickslip {

namespace baseline {
bool first_order(const double*, double*, std::size_t, std::size_t, const Recursion&) noexcept;
}
namespace avx2 {
bool first_order(const double*, double*, std::size_t, std::size_t, const Recursion&) noexcept;
}
namespace avx512 {
bool first_order(const double*, double*, std::size_t, std::size_t, const Recursion&) noexcept;
}

bool first_order(const double* x, double* y, std::size_t n, std::size_t channels, const Recursion& c) noexcept {
  switch (isa_in_use()) {
#ifdef STICKSLIP_HAS_AVX512
    case Isa::avx512: return avx512::first_order(x, y, n, channels, c);
#endif
#ifdef STICKSLIP_HAS_AVX2
    case Isa::avx2: return avx2::first_order(x, y, n, channels, c);
#endif
    default: return baseline::first_order(x, y, n, channels, c);
  }
}

}  // namespace stickslip
