// Picks the kernel build for this processor.
#include "stickslip/kernel.hpp"

namespace stickslip {

using Simulate = void(const stickslip_abi::Request&, const stickslip_abi::Sink&, stickslip_abi::Summary&);
using Sweep = void(const stickslip_abi::SweepRequest&, void*);
using Workspace = std::size_t();

#ifdef STICKSLIP_HAS_AVX2
namespace avx2 {
Simulate simulate;
Sweep sweep;
Workspace sweep_workspace;
}  // namespace avx2
#endif
#ifdef STICKSLIP_HAS_AVX512
namespace avx512 {
Simulate simulate;
Sweep sweep;
Workspace sweep_workspace;
}  // namespace avx512
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

void sweep(const stickslip_abi::SweepRequest& request, void* workspace) {
  switch (isa_in_use()) {
#ifdef STICKSLIP_HAS_AVX512
    case Isa::avx512: return avx512::sweep(request, workspace);
#endif
#ifdef STICKSLIP_HAS_AVX2
    case Isa::avx2: return avx2::sweep(request, workspace);
#endif
    default: return baseline::sweep(request, workspace);
  }
}

std::size_t sweep_workspace() {
  switch (isa_in_use()) {
#ifdef STICKSLIP_HAS_AVX512
    case Isa::avx512: return avx512::sweep_workspace();
#endif
#ifdef STICKSLIP_HAS_AVX2
    case Isa::avx2: return avx2::sweep_workspace();
#endif
    default: return baseline::sweep_workspace();
  }
}

}  // namespace dispatch

}  // namespace stickslip
