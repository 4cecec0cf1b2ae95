#pragma once

#include <vector>

#include "tune/kernels/kernels.hpp"

namespace wayfare::fitness_kernels {

/// Divides steps into intervals, and these into panels. An interval ends with an epoch, before another
/// plane, and after a second. Whether they are so long that propagating by intervals takes less time.
bool divide_into_intervals(std::vector<Step>& steps);

}  // namespace wayfare::fitness_kernels
