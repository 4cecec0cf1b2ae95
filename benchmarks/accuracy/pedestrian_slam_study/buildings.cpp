#include "buildings.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace wayfare::examples {
namespace {

using Route = std::vector<Eigen::Vector2d>;

constexpr double kCell_m = 0.25, kHalfWidth_m = 1.0, kAround_m = 2.0;

/// Whether a point is in the corridor along a segment parallel to x or y.
bool in_corridor(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Array2d low = a.array().min(b.array()) - kHalfWidth_m;
  const Eigen::Array2d high = a.array().max(b.array()) + kHalfWidth_m;
  return (p.array() > low).all() && (p.array() < high).all();
}

/// The route is moved so that the plan's lower left corner is its origin.
Walk walk(std::string name, Route route) {
  Eigen::Array2d low = route[0].array(), high = low;
  for (const auto& p : route) {
    low = low.min(p.array());
    high = high.max(p.array());
  }
  for (auto& p : route) p.array() += kAround_m - low;
  sim::CellMask mask;
  mask.cell_m = kCell_m;
  mask.width = static_cast<int>(std::ceil((high.x() - low.x() + 2 * kAround_m) / kCell_m));
  mask.height = static_cast<int>(std::ceil((high.y() - low.y() + 2 * kAround_m) / kCell_m));
  for (int row = 0; row < mask.height; ++row)
    for (int column = 0; column < mask.width; ++column) {
      const Eigen::Vector2d p((column + 0.5) * kCell_m, (mask.height - row - 0.5) * kCell_m);
      bool open = false;
      for (std::size_t i = 1; i < route.size(); ++i)
        open = open || in_corridor(p, route[i - 1], route[i]);
      mask.solid.push_back(open ? 0 : 1);
    }
  return {std::move(name), std::move(route), sim::FloorPlan::from_cells(mask).value()};
}

}  // namespace

std::vector<Walk> study_walks() {
  std::vector<Walk> walks;
  walks.push_back(walk("rectangle", Route{{0, 0}, {13, 0}, {13, 8}, {0, 8}, {0, 0}}));
  walks.push_back(walk(
      "eight",
      Route{{0, 0}, {14.5, 0}, {14.5, 7}, {0, 7}, {0, 14}, {14.5, 14}, {14.5, 7}, {0, 7}, {0, 0}}));
  walks.push_back(walk("corridors", Route{{0, 0}, {42, 0}, {42, 8}, {53, 8}, {53, 0}, {0, 0}}));
  return walks;
}

std::vector<Eigen::Vector2d> calibration_route() { return {{0, 0}, {20, 0}}; }

}  // namespace wayfare::examples
