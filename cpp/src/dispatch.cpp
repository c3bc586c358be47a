// Picks the kernel build for this processor.
#include "stickslip/kernel.hpp"

namespace stickslip {

using Simulate = void(const stickslip_abi::Request&, const stickslip_abi::Sink&, stickslip_abi::Summary&);

#ifdef STICKSLIP_HAS_AVX2
namespace avx2 {
Simulate simulate;
}
#endif
#ifdef STICKSLIP_HAS_AVX512
namespace avx512 {
Simulate simulate;
}
#endif

namespace dispatch {

void simulate(const stickslip_abi::Request& request, const stickslip_abi::Sink& sink, stickslip_abi::Summary& summary) {
  switch (isa_in_use()) {
#ifdef STICKSLIP_HAS_AVX512
    case Isa::avx512: return avx512::simulate(request, sink, summary);
#endif
#ifdef STICKSLIP_HAS_AVX2
    case Isa::avx2: return avx2::simulate(request, sink, summary);
#endif
    default: return baseline::simulate(request, sink, summary);
  }
}

}  // namespace dispatch

}  // namespace stickslip
