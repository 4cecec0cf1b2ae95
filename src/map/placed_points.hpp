#pragma once

#include <span>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/map/likelihood_field.hpp>

namespace wayfare::detail {

/// All points in the map's frame. Refused: none, one that is not finite or a map's size off; `what`
/// is to be made of them.
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
