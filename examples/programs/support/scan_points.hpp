#pragma once

// The measurements of a recording placed along a path.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <wayfare/io/report.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::examples {

/// The measurements to draw: those from `from` to `until`, the first `scans` and `frames` of them.
struct ScanChoice {
  LogTime from = LogTime::from_nanoseconds(std::numeric_limits<std::int64_t>::min()),
          until = LogTime::from_nanoseconds(std::numeric_limits<std::int64_t>::max());
  std::size_t scans = SIZE_MAX;   ///< of the LiDAR
  std::size_t frames = SIZE_MAX;  ///< of the radar
};

/// End points and detections in the path's frame, and the number of scans and frames they are of.
/// Measurements outside the path's time have no place and are left out.
struct ScanPoints {
  std::vector<Eigen::Vector2d> lidar_m, radar_m;
  std::size_t scans = 0, frames = 0;
};
[[nodiscard]] ScanPoints place_scans(const Recording& recording, const Trajectory& path,
                                     const ScanChoice& choice);

/// As points of a plot, at most one in every square of `spacing_m`.
[[nodiscard]] io::Series points_series(std::string name, std::span<const Eigen::Vector2d> points_m,
                                       double spacing_m);

}  // namespace wayfare::examples
