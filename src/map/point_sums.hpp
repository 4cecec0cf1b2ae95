#pragma once

// What maps of points are made of: the points of scans in the map frame, their sums and moments.

#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/map/cell.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare::detail {

/// All points in the map frame. Errors: no points, a point that is not finite or too far away.
/// `what` is the map to be built, for the messages.
[[nodiscard]] Result<PointSet> placed_points(std::span<const PlacedPoints> scans,
                                             std::string_view what);

/// The points of a square.
struct Square {
  Cell at;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double points = 0.0;
};

/// In the order of their first points. Errors as of voxel_filter.
[[nodiscard]] Result<std::vector<Square>> squares_of(const PointSet& points, double side_m);

[[nodiscard]] PointSet means_of(const std::vector<Square>& squares);

struct Moments {
  double n = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();

  void add(const Eigen::Vector2d& p, double weight = 1.0) {
    n += weight;
    sum += weight * p;
    squares += weight * p * p.transpose();
  }
};

/// Variances along and across the principal direction of a covariance, and its angle.
struct PrincipalAxes {
  double along, across, angle;
};

[[nodiscard]] PrincipalAxes principal_axes(const Eigen::Matrix2d& covariance);

}  // namespace wayfare::detail
