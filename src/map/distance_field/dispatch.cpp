#include "map/distance_field/kernels.hpp"

namespace wayfare::field_kernels {

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

const Kernels& variant_for(kernels::Isa isa) {
#ifdef WAYFARE_X86_KERNELS
  if (isa == kernels::Isa::avx2) return avx2::table;
  if (isa == kernels::Isa::avx512) return avx512::table;
#endif
  static_cast<void>(isa);
  return baseline::table;
}

const Kernels& best_variant() {
  using kernels::Isa;
  static const Kernels& best = variant_for(kernels::runs_here(Isa::avx512) ? Isa::avx512
                                           : kernels::runs_here(Isa::avx2) ? Isa::avx2
                                                                           : Isa::baseline);
  return best;
}

}  // namespace wayfare::field_kernels
