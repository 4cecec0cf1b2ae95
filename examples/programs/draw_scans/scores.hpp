#pragma once

// The scan matcher's scores and the samples of τ of one scan, in the map of the scans before it.

#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/radar_slam.hpp>

#include "support/program_files.hpp"

namespace wayfare::examples {

struct ScoreOptions {
  LogTime at;
  std::size_t frames = 20;  ///< radar frames in the scan
  double window_m = 0.6;    ///< half the width of the search window
  double window_deg = 5.0;  ///< the same of the heading
  double motion_m = 0.1;    ///< standard deviations of the motion about the path's pose
  double motion_deg = 3.0;
  int samples = 1000;
  std::uint64_t seed = 1;
};

/// Of one sensor.
struct Scores {
  std::string sensor;      ///< "LiDAR", "radar"
  std::string file;        ///< "lidar", "radar"
  io::Plot surface;        ///< ln p of the best heading at each position
  io::Plot tau;            ///< the weights of the samples
  io::Plot along, across;  ///< densities of scan, motion and τ in the robot's axes
  Facts facts;
};

/// Of each sensor that has a scan at the time; the maps are those of all scans before it, placed by
/// the path, with the parameters of radar_slam. Errors: the time has no pose, there is no scan from
/// there on, or no map before it.
[[nodiscard]] Result<std::vector<Scores>> scores_at(const Recording& recording,
                                                    const Trajectory& path,
                                                    const ScoreOptions& options);

}  // namespace wayfare::examples
