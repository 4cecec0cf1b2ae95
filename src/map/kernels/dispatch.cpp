#include "map/kernels/kernels.hpp"

namespace wayfare::kernels {

WAYFARE_DECLARE_VARIANTS(extern const Kernels table)

const Kernels& kernels_for(Isa isa) { return WAYFARE_VARIANT(isa, table); }
const Kernels& best_kernels() { return kernels_for(best_isa()); }

}  // namespace wayfare::kernels
