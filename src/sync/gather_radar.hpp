#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <wayfare/core/time.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sync/detail/radar_bearing.hpp>
#include <wayfare/sync/odometry_track.hpp>

namespace wayfare {

/// Frames as one scan: their points where the robot stood at `time`, that of the last frame.
struct GatheredRadar {
  LogTime time;
  PointSet points;
};

/// How many frames make one scan, and the longest time they may take.
struct GatherOptions {
  std::size_t frames = 20;
  double longest_s = 1.5;
};

/// How many of `frames`, from the first on, make one scan.
[[nodiscard]] std::size_t frames_of_one_scan(std::span<const RadarScan> frames,
                                             const GatherOptions& options = {});

/// All of `frames`, of which there is one at least, as one scan.
[[nodiscard]] GatheredRadar gather(std::span<const RadarScan> frames,
                                   const Transform2<frame::Base, frame::Radar>& T_base_radar,
                                   const RadarArray& array, const OdometryTrack& odometry);

/// A recording's frames in order, each placed by odometry where there is some, its bearings set
/// right for the motion odometry tells of: one frame is too sparse to be told from another. Points
/// that are not finite are left out. For recordings without wheels; RobotSynchroniser is for
/// those with.
[[nodiscard]] std::vector<GatheredRadar> gather_radar(const Recording& recording,
                                                      const OdometryTrack& odometry,
                                                      const GatherOptions& options = {});

}  // namespace wayfare
