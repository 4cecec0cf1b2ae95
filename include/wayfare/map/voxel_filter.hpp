#pragma once

#include <wayfare/core/result.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// One point for every square of `side_m` that holds any: their mean, in the order in which the
/// squares were first met. Refused: a side that is not positive, points that are not finite or more
/// than 2³⁰ squares from the origin.
[[nodiscard]] Result<PointSet> voxel_filter(const PointSet& points, double side_m);

}  // namespace wayfare
