#pragma once

#include <functional>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::examples {

/// Two overlapping scans and their relative pose.
struct ScanPair {
  const LaserScan* reference = nullptr;
  const LaserScan* scan = nullptr;
  SE2d T_reference_scan;
};

/// At most `count` pairs, evenly distributed over the recording, each `apart_m` apart, or less
/// after a rotation of 30°. The poses are those of graph SLAM.
[[nodiscard]] Result<std::vector<ScanPair>> pairs_of(const Recording& recording, std::size_t count,
                                                     double apart_m,
                                                     const std::function<bool(double)>& progress);

}  // namespace wayfare::examples
