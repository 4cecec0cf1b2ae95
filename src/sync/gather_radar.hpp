#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <wayfare/core/time.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sync/augmented_scans.hpp>
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

namespace detail {

/// Velocity of the radar in its own axes, over the adjacent frames; nullopt without odometry.
inline std::optional<Eigen::Vector2d> velocity_at(std::span<const RadarScan> frames, std::size_t i,
                                                  const SE2d& T_base_radar,
                                                  const OdometryTrack& odometry) {
  const LogTime from = frames[i > 0 ? i - 1 : 0].time,
                to = frames[std::min(i + 1, frames.size() - 1)].time;
  const auto a = odometry.at(from), b = odometry.at(to);
  if (!(to > from) || !a || !b) return std::nullopt;
  const SE2d moved = (a->raw() * T_base_radar).inverse() * (b->raw() * T_base_radar);
  return Eigen::Vector2d(moved.log().head<2>() / to_seconds(to - from));
}

}  // namespace detail

/// All of `frames`, at least one, as one scan, without points that move (SyncParams::moving_m_s).
[[nodiscard]] inline GatheredRadar gather(std::span<const RadarScan> frames,
                                          const Transform2<frame::Base, frame::Radar>& mounting,
                                          const RadarArray& array, const OdometryTrack& odometry,
                                          double moving_m_s = 0.0) {
  const SE2d& T_base_radar = mounting.raw();
  GatheredRadar scan{frames.back().time, {}};
  const auto last = odometry.at(scan.time);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto here = odometry.at(frames[i].time);
    const SE2d T_last_radar =
        last && here ? last->raw().inverse() * here->raw() * T_base_radar : T_base_radar;
    const auto velocity = detail::velocity_at(frames, i, T_base_radar, odometry);
    for (const RadarPoint& measured : frames[i].points) {
      if (velocity && moving_m_s > 0.0 && is_moving(measured, *velocity, array, moving_m_s))
        continue;
      const RadarPoint p = velocity ? compensate_bearing(measured, *velocity, array) : measured;
      const Eigen::Vector2d at = T_last_radar * Eigen::Vector2d(p.x_m, p.y_m);
      if (at.allFinite()) scan.points.push_back(at.cast<float>());
    }
  }
  return scan;
}

/// Number of `frames`, from the first, that form one scan.
[[nodiscard]] inline std::size_t frames_of_one_scan(std::span<const RadarScan> frames,
                                                    const GatherOptions& options = {}) {
  const std::size_t most = std::min(frames.size(), std::max<std::size_t>(options.frames, 1));
  std::size_t n = std::min<std::size_t>(most, 1);
  while (n < most && to_seconds(frames[n].time - frames.front().time) <= options.longest_s) ++n;
  return n;
}

/// A recording's frames in order, since one frame is too sparse for matching; each is placed by
/// odometry where available, its bearings corrected for the motion. Points that are not finite are
/// dropped. For recordings without wheels; with wheels, use RobotSynchroniser.
[[nodiscard]] inline std::vector<GatheredRadar> gather_radar(const Recording& recording,
                                                             const OdometryTrack& odometry,
                                                             const GatherOptions& options = {}) {
  const RadarArray array{.max_speed_m_s = recording.radar_max_speed_m_s};
  std::vector<GatheredRadar> scans;
  for (std::span<const RadarScan> remaining = recording.radar; !remaining.empty();) {
    const std::size_t n = frames_of_one_scan(remaining, options);
    scans.push_back(gather(remaining.first(n), recording.T_base_radar, array, odometry));
    remaining = remaining.subspan(n);
  }
  return scans;
}

}  // namespace wayfare
