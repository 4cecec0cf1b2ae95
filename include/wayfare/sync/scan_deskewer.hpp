#pragma once

// The motion of a robot's laser during a sweep, by odometry, by a gyro or at constant velocity, and
// the choice among them.

#include <optional>
#include <span>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/sensors/deskew.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sync/odometry_track.hpp>

namespace wayfare {

/// The laser's pose by odometry samples in order of time, along the constant twist between two;
/// nothing outside them, and between samples half a second apart or more. With a gyro the heading
/// is that at `at` and its turn since then: slipping wheels move a robot well, and turn it badly;
/// nothing then where the gyro is silent. A SweepMotion.
class OdometryMotion {
 public:
  /// Refers to the samples.
  OdometryMotion(std::span<const OdometrySample> samples,
                 const Transform2<frame::Base, frame::Laser>& T_base_laser)
      : samples_(samples), T_base_laser_(T_base_laser.raw()) {}
  /// With the gyro's turn since `at`.
  OdometryMotion(std::span<const OdometrySample> samples,
                 const Transform2<frame::Base, frame::Laser>& T_base_laser, LogTime at,
                 std::span<const GyroSample> gyro)
      : samples_(samples), T_base_laser_(T_base_laser.raw()), at_(at), gyro_(gyro) {}
  /// At `time`, by odometry.
  [[nodiscard]] std::optional<SE2d> operator()(LogTime time) const;

 private:
  [[nodiscard]] std::optional<SE2d> base_at(LogTime time) const;

  std::span<const OdometrySample> samples_;
  SE2d T_base_laser_;
  LogTime at_;
  std::span<const GyroSample> gyro_;
};

/// The laser's pose on a base that is at the origin at `at`: moving with `velocity` (m/s and rad/s
/// in its own axes), and turning by a gyro where there is one, then nowhere it is silent. A
/// SweepMotion.
class VelocityMotion {
 public:
  /// Refers to the gyro's samples.
  VelocityMotion(LogTime at, const Eigen::Vector3d& velocity,
                 const Transform2<frame::Base, frame::Laser>& T_base_laser,
                 std::span<const GyroSample> gyro = {})
      : at_(at), velocity_(velocity), T_base_laser_(T_base_laser.raw()), gyro_(gyro) {}
  /// At `time`, from the base at the first instant.
  [[nodiscard]] std::optional<SE2d> operator()(LogTime time) const;

 private:
  LogTime at_;
  Eigen::Vector3d velocity_;
  SE2d T_base_laser_;
  std::span<const GyroSample> gyro_;
};

/// Makes the sweeps of a recording or a running robot instantaneous, at their own times, by the
/// best motion that covers each of them: odometry; the gyro, with the velocity between the last two
/// poses found; this velocity alone. Before two poses are known, and without any of the others, a
/// sweep is left as it is.
class ScanDeskewer {
 public:
  /// For a laser at this pose on its base.
  explicit ScanDeskewer(const Transform2<frame::Base, frame::Laser>& T_base_laser)
      : T_base_laser_(T_base_laser) {}

  /// The scan itself if all of its beams are of one time; else one that is valid until the next
  /// call. Samples are in order of time. Errors as for `deskew`.
  [[nodiscard]] Result<const LaserScan*> operator()(const LaserScan& scan,
                                                    std::span<const OdometrySample> odometry,
                                                    std::span<const GyroSample> gyro = {});

  /// The pose found for a scan; `moved`: the map's frame moved since the one before, e.g. by a loop
  /// closure, so that their difference is no velocity.
  void placed(LogTime time, const SE2d& T_map_base, bool moved = false);

 private:
  struct Placed {
    LogTime time;
    SE2d T_map_base;
  };

  Transform2<frame::Base, frame::Laser> T_base_laser_;
  std::optional<Placed> last_;
  std::optional<Eigen::Vector3d> velocity_;  // of the base, in its own axes, per second
  LaserScan instant_;
};

}  // namespace wayfare
