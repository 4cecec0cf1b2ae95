#include "map/point_sums.hpp"

#include <cmath>
#include <cstddef>
#include <string>

namespace wayfare::detail {

Result<PointSet> placed_points(std::span<const PlacedPoints> scans, std::string_view what) {
  PointSet points;
  for (const PlacedPoints& scan : scans) {
    if (scan.points == nullptr)
      return Error{ErrorCode::invalid, std::string(what) + ": a pose without points"};
    for (std::size_t i = 0; i < scan.points->size(); ++i) {
      const Eigen::Vector2d p =
          scan.T_map_points * Eigen::Vector2d((*scan.points)[i].cast<double>());
      if (!(p.cwiseAbs().maxCoeff() < 1e7))
        return Error{ErrorCode::invalid,
                     std::string(what) + ": a point or pose is not finite, or too far"};
      points.push_back(p.cast<float>());
    }
  }
  if (points.empty()) return Error{ErrorCode::invalid, std::string(what) + ": no points"};
  return points;
}

PrincipalAxes principal_axes(const Eigen::Matrix2d& c) {
  const double half_trace = 0.5 * c.trace();
  const double spread = std::hypot(0.5 * (c(0, 0) - c(1, 1)), c(0, 1));
  return {half_trace + spread, half_trace - spread,
          0.5 * std::atan2(2 * c(0, 1), c(0, 0) - c(1, 1))};
}

}  // namespace wayfare::detail
