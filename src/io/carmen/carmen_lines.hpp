#pragma once

// Private: parses single lines of a CARMEN log; carmen.cpp combines them.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/sensors/laser_scan.hpp>
#include <wayfare/sensors/radar_scan.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sensors/wheels.hpp>

#include "io/text/text.hpp"

namespace wayfare::io::carmen {

/// The scan of one line. Bearings are set only where the line contains them.
struct ScanLine {
  std::size_t line = 0;
  LaserScan scan;
  bool has_bearings = false;
  std::optional<SE2d> laser_pose;
  std::optional<SE2d> robot_pose;
};

/// A measurement and its line number.
template <class T>
struct Measured {
  std::size_t line = 0;
  T value = {};
};

/// Parses lines after their first word. The caller adds line and source to an error.
class LineParser {
 public:
  /// FLASER and RLASER.
  Result<ScanLine> laser(text::Tokens tokens, bool terminated);
  /// ROBOTLASER1 and 2 (`with_poses`), RAWLASER1 and 2.
  Result<ScanLine> robot_laser(text::Tokens tokens, bool with_poses, bool terminated);
  /// `Laser n r1..rn`, time left at zero.
  Result<ScanLine> bare_laser(text::Tokens tokens);
  /// ODOM.
  Result<OdometrySample> odom(text::Tokens tokens, bool terminated);
  /// RADAR, WHEELS, GYRO and TRUEPOS.
  Result<RadarScan> radar(text::Tokens tokens, bool terminated);
  Result<WheelSample> wheels(text::Tokens tokens, bool terminated);
  Result<GyroSample> gyro(text::Tokens tokens, bool terminated);
  Result<StampedPose> true_pose(text::Tokens tokens, bool terminated);
  /// `Odometry x y θ`, time left at zero.
  static Result<OdometrySample> bare_odometry(text::Tokens tokens);

  /// Ranges of the last scan that were not finite or negative; they are NaN in it.
  [[nodiscard]] std::size_t invalid_ranges() const { return invalid_ranges_; }

  /// Points of the last radar line that were not finite; they are not in its scan.
  [[nodiscard]] std::size_t invalid_points() const { return invalid_points_; }

 private:
  Result<void> ranges(text::Tokens& tokens, std::vector<float>& values);
  Result<void> time_and_host(text::Tokens& tokens, bool terminated, LogTime& time);
  /// `make(numbers, time)` of a line of numbers, `what`, and the time.
  template <std::size_t kNumbers, class Make>
  auto stamped(text::Tokens tokens, bool terminated, const char* what, const Make& make)
      -> Result<decltype(make(nullptr, LogTime()))>;

  std::size_t invalid_ranges_ = 0;
  std::size_t invalid_points_ = 0;
  bool host_seen_ = false;
};

}  // namespace wayfare::io::carmen
