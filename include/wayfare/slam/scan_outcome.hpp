#pragma once

// What all SLAM systems that follow scans return and call.

#include <functional>

#include <wayfare/core/frame.hpp>

namespace wayfare {

/// What became of one scan.
struct ScanOutcome {
  Transform2<frame::Map, frame::Base> T_map_base;
  double score = 0.0;    ///< agreement with the local map in [0, 1]; 0 where not matched
  bool matched = false;  ///< false: too few points or no agreement, the motion model stands
  bool became_node = false;
  int loop_closures = 0;  ///< found at this scan
};

/// Called with the fraction done; return false to stop, which ends with what there is so far.
using SlamProgress = std::function<bool(double fraction)>;

}  // namespace wayfare
