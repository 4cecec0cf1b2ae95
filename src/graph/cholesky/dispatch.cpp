#include "graph/cholesky/kernels.hpp"

namespace wayfare::cholesky {

WAYFARE_DECLARE_VARIANTS(const FrontKernels& table(int block))

const FrontKernels& kernels_for(Isa isa, int block) { return WAYFARE_VARIANT(isa, table(block)); }
const FrontKernels& best_kernels(int block) { return kernels_for(best_isa(), block); }

}  // namespace wayfare::cholesky
