#pragma once

#include <span>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/map/likelihood_field.hpp>

namespace wayfare::detail {

/// All points in the map frame. Errors: no points, a point that is not finite or too far away.
/// `what` is the map to be built, for the messages.
inline Result<PointSet> placed_points(std::span<const PlacedPoints> scans, std::string_view what) {
  PointSet points;
  for (const PlacedPoints& scan : scans)
    for (std::size_t i = 0; i < scan.points->size(); ++i) {
      const Eigen::Vector2d p =
          scan.T_map_points * Eigen::Vector2d((*scan.points)[i].cast<double>());
      if (!(p.cwiseAbs().maxCoeff() < 1e7))
        return Error{ErrorCode::invalid,
                     std::string(what) + ": a point or pose is not finite, or too far"};
      points.push_back(p.cast<float>());
    }
  if (points.empty()) return Error{ErrorCode::invalid, std::string(what) + ": no points"};
  return points;
}

}  // namespace wayfare::detail
