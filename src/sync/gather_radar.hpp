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

/// Frames as one scan, in the robot's pose at `time`, that of the last frame.
struct GatheredRadar {
  LogTime time;
  PointSet points;
};

/// Number of frames per scan, and their longest duration.
struct GatherOptions {
  std::size_t frames = 20;
  double longest_s = 1.5;
};

/// Number of `frames`, from the first, that form one scan.
[[nodiscard]] std::size_t frames_of_one_scan(std::span<const RadarScan> frames,
                                             const GatherOptions& options = {});

/// All of `frames`, at least one, as one scan.
[[nodiscard]] GatheredRadar gather(std::span<const RadarScan> frames,
                                   const Transform2<frame::Base, frame::Radar>& T_base_radar,
                                   const RadarArray& array, const OdometryTrack& odometry);

/// A recording's frames in order, since one frame is too sparse for matching; each is placed by
/// odometry where available, its bearings corrected for the motion. Points that are not finite are
/// dropped. For recordings without wheels; with wheels, use RobotSynchroniser.
[[nodiscard]] std::vector<GatheredRadar> gather_radar(const Recording& recording,
                                                      const OdometryTrack& odometry,
                                                      const GatherOptions& options = {});

}  // namespace wayfare
