#pragma once

// Localisers of any type in a run over a recording.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/localisation.hpp>
#include <wayfare/sync/odometry_track.hpp>

namespace wayfare::detail {

class RecordedLocaliser {
 public:
  using Odometry = std::optional<Transform2<frame::Odom, frame::Base>>;

  virtual ~RecordedLocaliser() = default;
  /// Called before each scan.
  virtual void before(std::size_t scan) = 0;
  virtual Result<void> add_motion(LogTime time, const Odometry& odometry) = 0;
  virtual Result<LocalisationOutcome> add_lidar(const LaserScan& scan,
                                                const Odometry& odometry) = 0;
  virtual Result<LocalisationOutcome> add_radar(LogTime time, const PointSet& points_base,
                                                const Odometry& odometry) = 0;
  [[nodiscard]] virtual std::vector<PoseParticle> particles() const = 0;
};

/// Adds the odometry in a gap between scans to a localiser, in steps short enough to be single
/// arcs.
template <class L>
void add_odometry_of_gap(L& localiser, const OdometryTrack& odometry, LogTime from, LogTime to) {
  constexpr Duration kStep{500'000'000};
  if (to - from <= 2 * kStep) return;
  const auto steps = std::min<std::int64_t>((to - from) / kStep, 7200);
  for (std::int64_t k = 1; k < steps; ++k) {
    const LogTime time = from + (to - from) / steps * k;
    // A step whose time does not advance is refused; the next one covers it.
    static_cast<void>(localiser.add_motion(time, odometry.at(time)).has_value());
  }
}

/// Refuses bearings that are not finite, and a scan not later than the last of any sensor.
Result<void> check_lidar(const LaserScan& scan, const std::optional<LogTime>& last);
/// Refuses points that are not finite, and a scan earlier than the last of any sensor.
Result<void> check_radar(LogTime time, const PointSet& points_base,
                         const std::optional<LogTime>& last);

/// Sensors of a recording that are used, and the frames of a radar that make one scan.
struct RecordedSensors {
  bool lidar = true, radar = true;
  std::size_t radar_frames = RadarWeighing().frames;
  double radar_longest_s = RadarWeighing().longest_s;
};

Result<LocalisationRun> run(RecordedLocaliser& localiser, const Recording& recording,
                            const RecordedSensors& sensors,
                            const std::function<bool(double)>& progress,
                            std::span<const double> snapshots_at);

}  // namespace wayfare::detail
