#include "tune/kernels/kernels.hpp"

namespace wayfare::fitness_kernels {

WAYFARE_DECLARE_VARIANTS(extern const Kernel table)

const Kernel& kernel_for(Isa isa) { return WAYFARE_VARIANT(isa, table); }

}  // namespace wayfare::fitness_kernels
