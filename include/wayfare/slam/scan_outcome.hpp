#pragma once

// Types common to the SLAM systems that process scans.

#include <functional>

#include <wayfare/core/frame.hpp>

namespace wayfare {

/// Result of one scan.
struct ScanOutcome {
  Transform2<frame::Map, frame::Base> T_map_base;
  double score = 0.0;    ///< agreement with the local map in [0, 1]; 0 where not matched
  bool matched = false;  ///< false: too few points or poor agreement; the predicted pose is kept
  bool became_node = false;
  int loop_closures = 0;  ///< found at this scan
};

/// Called with the fraction done; return false to stop and keep the results so far.
using SlamProgress = std::function<bool(double fraction)>;

}  // namespace wayfare
