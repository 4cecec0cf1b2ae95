#pragma once

// Robot logs in CARMEN's text format and its common variants.
//
//   FLASER n r1..rn  x y θ  odom_x odom_y odom_θ  ipc_time host logger_time     (front laser)
//   RLASER …                                                                    (rear laser)
//   ROBOTLASER1 type start fov step max accuracy remission n r1..rn m i1..im
//               laser_x laser_y laser_θ  robot_x robot_y robot_θ  tv rv safety×3
//               ipc_time host logger_time                           (ROBOTLASER2: rear laser)
//   RAWLASER1   the same up to the remissions, then the times
//   ODOM x y θ tv rv acceleration  ipc_time host logger_time
//   TRUEPOS x y θ  odom_x odom_y odom_θ  ipc_time host logger_time
//   PARAM name value
//   Odometry x y θ  /  Laser n r1..rn            (pairs without a time)
//
// and, as an extension of CARMEN,
//
//   RADAR n  x1 y1 z1 v1 snr1 … xn yn zn vn snrn  ipc_time host logger_time
//   WHEELS left right  ipc_time host logger_time  (metres rolled since the previous line)
//   GYRO turn_rate  ipc_time host logger_time     (mean since the previous line)
//
// Host and logger time may be missing. Comments and empty lines are skipped, lines of other kinds
// counted. A malformed line is reported by number and skipped.

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::io {

/// Ranges, times and limits of read_carmen.
struct CarmenOptions {
  /// Shorter ranges are not returns, metres. Logs write 0 for a beam that failed.
  float min_range_m = 0.05F;
  /// Ranges from here on are not returns, metres; a smaller limit in the log takes precedence. SICK
  /// scanners in 80 m mode write 81.83 to 81.91 for no return.
  float max_range_m = 80.0F;
  /// Detects the value that means "no return" below `max_range_m` (8.183, 51.05 …): the largest
  /// range of the log, if it is far more frequent than those just below it.
  bool find_no_return_value = true;
  /// Time from one `Odometry`/`Laser` pair to the next, for logs without time stamps.
  Duration pair_period = from_seconds(0.1);
  /// Problems kept in full; all are counted.
  std::size_t max_problems = 100;
  /// Whether a log without laser scans is an error.
  bool needs_laser = true;
  ReadOptions file = {};  ///< limits of the file
};

/// Where a log's odometry is from.
enum class OdometrySource {
  none,         ///< the log has no odometry
  odom_lines,   ///< ODOM (or Odometry) lines
  scan_fields,  ///< the odometry written with each scan
};

/// What the times of a log are.
enum class ClockState {
  usable,        ///< its time stamps
  continued,     ///< its stamps, of a clock that was set back: later ones are moved on
  interpolated,  ///< its stamps; those out of order are between their neighbours
  logger,        ///< the logger's times, the last column: the stamps are not usable
  numbered,      ///< the order of the file: there are no usable stamps
};

/// Counts of lines and measurements.
struct CarmenStatistics {
  std::size_t lines = 0;           ///< of the file
  std::size_t scans = 0;           ///< in the recording
  std::size_t rear_scans = 0;      ///< in `rear_scans`
  std::size_t odometry = 0;        ///< in the recording
  std::size_t radar_scans = 0;     ///< in the recording, including empty ones
  std::size_t radar_points = 0;    ///< in the recording
  std::size_t wheels = 0;          ///< in the recording
  std::size_t gyro = 0;            ///< in the recording
  std::size_t true_poses = 0;      ///< in the recording
  std::size_t skipped_lines = 0;   ///< malformed, or out of time order
  std::size_t invalid_ranges = 0;  ///< not finite or negative: treated as no return
  std::size_t invalid_points = 0;  ///< of radar lines, not finite: dropped
  OdometrySource odometry_source = OdometrySource::none;  ///< of the recording
  /// Ranges from here on are not returns, metres.
  float max_range_m = 0.0F;
  bool compressed = false;                   ///< by gzip
  ClockState clock = ClockState::usable;     ///< what the times are
  std::string clock_reason;                  ///< where times are not the stamps; else empty
  std::map<std::string, std::size_t> other;  ///< unused lines, by their first word
};

/// A log as a recording, with what is not part of one.
struct CarmenLog {
  /// Front laser, odometry, radar, wheels, gyro and truth. Times are the log's IPC time stamps,
  /// exact to the nanosecond and not decreasing; equal stamps occur. Of lines out of order, the
  /// largest ordered subset is kept. Where more than a hundredth of the scans would be lost, or
  /// nearly all stamps are equal, times are repaired: see ClockState. Scans then have the odometry
  /// of their own line, if there is one, unless the clock was only set back.
  Recording recording;
  /// The laser pose written with each scan: by odometry in a raw log, from the corrected trajectory
  /// in a corrected one. One per scan of the recording, or empty.
  Trajectory reported_poses;
  /// Scans of the rear laser, bearings relative to its own axis, which points backwards.
  std::vector<LaserScan> rear_scans;
  std::map<std::string, std::string> parameters;  ///< PARAM lines; the last value is kept
  Problems problems;                              ///< lines skipped or changed
  CarmenStatistics statistics;                    ///< counts
};

/// Field of view: 180 or 181 beams are 1° apart from −90°, 360 or 361 are 0.5° apart; any other
/// number spans 180° (from −90°, step π/n, or π/(n−1) for odd n, which has a beam at +90°) unless
/// PARAM laser_frontlaser_fov and laser_frontlaser_resolution (degrees) specify it. ROBOTLASER and
/// RAWLASER lines contain their own.
///
/// Odometry: the ODOM lines if at least two are in order and cover half the scans' time or more;
/// else the odometry written with the scans.
///
/// A radar, wheel, gyro or truth line with the time stamp of the previous one is a duplicate: it is
/// reported and dropped. PARAM robot_wheelbase, robot_radar_offset, robot_radar_side_offset and
/// robot_radar_angular_offset (metres and radians from the robot's centre) are their mounting.
///
/// A truncated gzip file is read up to the truncation, with a problem. Errors: the file cannot be
/// read, or contains no usable scan (without `needs_laser`: no usable line).
[[nodiscard]] Result<CarmenLog> read_carmen(const std::string& path,
                                            const CarmenOptions& options = {});
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<CarmenLog> parse_carmen(std::string_view text, const std::string& source,
                                             const CarmenOptions& options = {});

/// `recording` as a CARMEN log, all streams in order of time: ODOM, WHEELS, GYRO, TRUEPOS and RADAR
/// lines and the scans with interpolated odometry. A scan of the geometry of a FLASER line (180 deg
/// from -90 deg in steps of 1 or 0.5 deg, the laser mounted straight ahead) is written as one,
/// others as ROBOTLASER1. Numbers read back to the same bits; times are exact, with nine decimals.
[[nodiscard]] std::string format_carmen(const Recording& recording);

/// Errors: the file exists (see WriteOptions), or cannot be written.
[[nodiscard]] inline Result<void> write_carmen(const std::string& path, const Recording& recording,
                                               const WriteOptions& options = {}) {
  return write_file(path, format_carmen(recording), options);
}

}  // namespace wayfare::io
