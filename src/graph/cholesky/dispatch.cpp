#include "graph/cholesky/kernels.hpp"

namespace wayfare::cholesky {

namespace baseline {
const FrontKernels& table(int block);
}
#ifdef WAYFARE_X86_KERNELS
namespace avx2 {
const FrontKernels& table(int block);
}
namespace avx512 {
const FrontKernels& table(int block);
}
#endif

bool supported(kernels::Isa isa) {
#ifdef WAYFARE_X86_KERNELS
  if (isa != kernels::Isa::baseline && __builtin_cpu_supports("fma") == 0) return false;
#endif
  return kernels::runs_here(isa);
}

const FrontKernels& kernels_for(kernels::Isa isa, int block) {
#ifdef WAYFARE_X86_KERNELS
  if (isa == kernels::Isa::avx2) return avx2::table(block);
  if (isa == kernels::Isa::avx512) return avx512::table(block);
#endif
  static_cast<void>(isa);
  return baseline::table(block);
}

const FrontKernels& best_kernels(int block) {
  using kernels::Isa;
  static const Isa best = supported(Isa::avx512) ? Isa::avx512
                          : supported(Isa::avx2) ? Isa::avx2
                                                 : Isa::baseline;
  return kernels_for(best, block);
}

}  // namespace wayfare::cholesky
