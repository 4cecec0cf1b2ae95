#include "map/distance_field/kernels.hpp"

namespace wayfare::field_kernels {

WAYFARE_DECLARE_VARIANTS(extern const Kernels table)

const Kernels& variant_for(Isa isa) { return WAYFARE_VARIANT(isa, table); }
const Kernels& best_variant() { return variant_for(best_isa()); }

}  // namespace wayfare::field_kernels
