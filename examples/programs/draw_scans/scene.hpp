#pragma once

// Scans along a path over a map and a floor plan.

#include <optional>
#include <span>
#include <string>

#include <wayfare/io/map_image.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/sim/floor_plan.hpp>

#include "support/scan_points.hpp"

namespace wayfare::examples {

/// A square of the map's frame; all if none.
struct View {
  Eigen::Vector2d middle_m = Eigen::Vector2d::Zero();
  double half_m = 0.0;

  [[nodiscard]] bool has(const Eigen::Vector2d& p) const {
    return half_m <= 0.0 || (p - middle_m).cwiseAbs().maxCoeff() <= half_m;
  }
};

struct Scene {
  std::string title;
  std::optional<io::GridImage> map;
  std::optional<sim::FloorPlan> plan;
  SE2d T_map_plan;
  ScanPoints points;
  Trajectory path;         ///< the part that is drawn
  Trajectory truth;        ///< in the map's frame; may be empty
  std::optional<SE2d> at;  ///< the robot at the chosen time
  View view;
};

/// The part of the grid within the view; its origin must not be rotated.
[[nodiscard]] io::GridImage cropped(const io::GridImage& grid, const View& view);

[[nodiscard]] io::Plot scene_plot(const Scene& scene);

}  // namespace wayfare::examples
