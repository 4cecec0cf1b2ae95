#pragma once

#include <vector>

#include <wayfare/core/time.hpp>
#include <wayfare/measure/point_set.hpp>
#include <wayfare/measure/recording.hpp>
#include <wayfare/sync/odometry_track.hpp>
#include <wayfare/system/localisation.hpp>

namespace wayfare {

/// Frames as one scan: their points where the robot stood at `time`, that of the last frame.
struct GatheredRadar {
  LogTime time;
  PointSet points;
};

/// A recording's frames in order, as many at a time as the options say, each placed by odometry:
/// one frame is too sparse to be told from another. Points that are not finite are left out.
[[nodiscard]] std::vector<GatheredRadar> gather_radar(const Recording& recording,
                                                      const OdometryTrack& odometry,
                                                      const RadarWeighing& options);

}  // namespace wayfare
