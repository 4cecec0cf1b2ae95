#include "map/kernels/kernels.hpp"

namespace wayfare::kernels {

namespace baseline {
extern const Kernels table;
}
#ifdef WAYFARE_X86_KERNELS
namespace avx2 {
extern const Kernels table;
}
namespace avx512 {
extern const Kernels table;
}
#endif

bool runs_here(Isa isa) {
#ifdef WAYFARE_X86_KERNELS
  if (isa == Isa::avx2) return __builtin_cpu_supports("avx2") != 0;
  if (isa == Isa::avx512)
    return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
           __builtin_cpu_supports("avx512vl") != 0 && __builtin_cpu_supports("avx512dq") != 0;
#endif
  return isa == Isa::baseline;
}

const Kernels& kernels_for(Isa isa) {
#ifdef WAYFARE_X86_KERNELS
  if (isa == Isa::avx2) return avx2::table;
  if (isa == Isa::avx512) return avx512::table;
#endif
  static_cast<void>(isa);
  return baseline::table;
}

const Kernels& best_kernels() {
  static const Kernels& best = kernels_for(runs_here(Isa::avx512) ? Isa::avx512
                                           : runs_here(Isa::avx2) ? Isa::avx2
                                                                  : Isa::baseline);
  return best;
}

}  // namespace wayfare::kernels
