#pragma once

#include <functional>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::examples {

/// Two scans that overlap, and where the second was seen from the first.
struct ScanPair {
  const LaserScan* reference = nullptr;
  const LaserScan* scan = nullptr;
  SE2d T_reference_scan;
};

/// At most `count` pairs from all over the recording, each `apart_m` of travel apart, or less where
/// the robot turned by 30° first. The poses are graph SLAM's.
[[nodiscard]] Result<std::vector<ScanPair>> pairs_of(const Recording& recording, std::size_t count,
                                                     double apart_m,
                                                     const std::function<bool(double)>& progress);

}  // namespace wayfare::examples
