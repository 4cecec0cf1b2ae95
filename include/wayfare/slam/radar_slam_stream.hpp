#pragma once

// The particle filter for measurements that arrive one by one, as on a robot.

#include <memory>
#include <optional>
#include <string_view>

#include <wayfare/sensors/laser_scan.hpp>
#include <wayfare/sensors/radar_scan.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sensors/wheels.hpp>
#include <wayfare/slam/radar_slam.hpp>
#include <wayfare/sync/augmented_scans.hpp>

namespace wayfare {

/// Source of the motion between scans.
enum class MotionSource {
  wheels,    ///< and the gyro; odometry is ignored
  odometry,  ///< as poses; wheels and gyro are ignored
  none       ///< the pose is expected to stay, with a wide search
};

struct RadarSlamStreamOptions {
  RadarSlamOptions slam{};  ///< with the laser's mounting pose
  SlamSensors sensors = SlamSensors::both;
  MotionSource motion = MotionSource::odometry;
  DeadReckoningOptions reckoning{};
  /// The radar's mounting pose, and how long to wait for a stream by the measurements' clock; with
  /// wheels all of its parameters apply.
  SyncParams sync{};
};

/// Takes each stream in its own order. Interleaving and batching of the streams do not change the
/// result as long as none lags by more than `sync.max_wait`. Not thread-safe.
class RadarSlamStream {
 public:
  explicit RadarSlamStream(const RadarSlamStreamOptions& options = {});
  ~RadarSlamStream();
  RadarSlamStream(RadarSlamStream&&) noexcept;
  RadarSlamStream& operator=(RadarSlamStream&&) noexcept;

  /// A measurement not later than the last of its stream, or than the last one processed, is
  /// refused and counted.
  void add(const WheelSample& sample);
  void add(const GyroSample& sample);
  void add(const OdometrySample& sample);
  void add(const RadarScan& scan);
  void add(const LaserScan& scan);
  /// Processes what is queued without further waiting. With wheels nothing may follow; otherwise
  /// later measurements are waited for again.
  void finish();

  /// Processes the next measurement in order of time, once its data is complete. Returns the time
  /// reached; nothing if data is missing.
  std::optional<LogTime> step();
  /// The stream that delays a scan ("odometry"); empty if none. Not determined with wheels.
  [[nodiscard]] std::string_view waits_for() const;

  [[nodiscard]] const RadarSlam& slam() const;
  /// Of the sensor that frees cells, if used.
  [[nodiscard]] const OccupancyGrid& map() const;
  /// Results so far.
  [[nodiscard]] RadarSlamRun result() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wayfare
