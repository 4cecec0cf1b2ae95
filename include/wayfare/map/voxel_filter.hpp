#pragma once

#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// The mean of the points in each square of `side_m`, in the order of the squares' first points.
/// Errors: a side that is not positive, points that are not finite or more than 2³⁰ squares from
/// the origin.
[[nodiscard]] Result<PointSet> voxel_filter(const PointSet& points, double side_m);

}  // namespace wayfare
