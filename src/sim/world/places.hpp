#pragma once

#include <vector>

#include <Eigen/Core>

namespace wayfare::sim {

/// Points every half metre of the path.
[[nodiscard]] inline std::vector<Eigen::Vector2d> places_along(
    const std::vector<Eigen::Vector2d>& route_m) {
  std::vector<Eigen::Vector2d> places;
  for (std::size_t i = 1; i < route_m.size(); ++i) {
    const Eigen::Vector2d leg = route_m[i] - route_m[i - 1];
    const int steps = 1 + static_cast<int>(leg.norm() / 0.5);
    for (int k = 0; k < steps; ++k) places.emplace_back(route_m[i - 1] + k * leg / steps);
  }
  return places;
}

}  // namespace wayfare::sim
