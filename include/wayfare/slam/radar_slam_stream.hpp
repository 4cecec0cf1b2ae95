#pragma once

// The particle filter fed measurement by measurement, as a robot gives them.

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

/// What tells how the robot moved between scans.
enum class MotionFrom {
  wheels,    ///< and the gyro; odometry is left alone
  odometry,  ///< as poses; wheels and gyro are left alone
  nothing    ///< the robot is about where it was
};

struct RadarSlamStreamOptions {
  RadarSlamOptions slam{};  ///< with where the laser is
  SlamSensors sensors = SlamSensors::both;
  MotionFrom motion = MotionFrom::odometry;
  DeadReckoningOptions reckoning{};
  /// Where the radar is, and how long a stream is waited for by the measurements' clock; with
  /// wheels all of it.
  SyncParams sync{};
};

/// Takes each stream in its own order. How the streams are interleaved, and in what portions they
/// come, does not change the result as long as none lags by more than `sync.max_wait`. Not
/// thread-safe.
class RadarSlamStream {
 public:
  explicit RadarSlamStream(const RadarSlamStreamOptions& options = {});
  ~RadarSlamStream();
  RadarSlamStream(RadarSlamStream&&) noexcept;
  RadarSlamStream& operator=(RadarSlamStream&&) noexcept;

  /// What is not later than the one before of its stream, or than what was worked on, is refused
  /// and counted.
  void add(const WheelSample& sample);
  void add(const GyroSample& sample);
  void add(const OdometrySample& sample);
  void add(const RadarScan& scan);
  void add(const LaserScan& scan);
  /// What waits is worked on without waiting further. With wheels nothing may come any more; else
  /// what comes afterwards is waited for again.
  void finish();

  /// Works on what is next in order of time, once all that belongs to it is there; up to when that
  /// leads. Nothing: it is not there.
  std::optional<LogTime> step();
  /// The stream that keeps a scan waiting ("odometry"); empty: none does. Not told of wheels.
  [[nodiscard]] std::string_view waits_for() const;

  [[nodiscard]] const RadarSlam& slam() const;
  /// Of the sensor that frees cells, where there is one.
  [[nodiscard]] const OccupancyGrid& map() const;
  /// All of it so far.
  [[nodiscard]] RadarSlamRun result() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wayfare
