#pragma once

// Robot logs in CARMEN's text format, in the many variants found in the wild.
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
// and, beyond what CARMEN knows,
//
//   RADAR n  x1 y1 z1 v1 snr1 … xn yn zn vn snrn  ipc_time host logger_time
//   WHEELS left right  ipc_time host logger_time  (metres rolled since the line before)
//   GYRO turn_rate  ipc_time host logger_time     (mean since the line before)
//
// Host and logger time may be missing. Comments and empty lines are skipped, lines of other kinds
// counted. A malformed line is reported by number and skipped; reading goes on.

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::io {

struct CarmenOptions {
  /// Shorter ranges are no returns, metres. Logs write 0 for a beam that failed.
  float min_range_m = 0.05F;
  /// Ranges from here on are no returns, metres; a log's own smaller limit comes first. SICK
  /// scanners in 80 m mode write 81.83 to 81.91 for no return.
  float max_range_m = 80.0F;
  /// Finds the value a log writes for "no return" below `max_range_m` (8.183, 51.05 …): the range
  /// at the top of the whole log that is far more frequent than any just below it.
  bool find_no_return_value = true;
  /// Time from one `Odometry`/`Laser` pair to the next, for logs without time stamps.
  Duration pair_period = from_seconds(0.1);
  /// Problems kept in full; all are counted.
  std::size_t max_problems = 100;
  /// Whether a log without a laser scan is an error; else what there is is read.
  bool needs_laser = true;
  ReadOptions file = {};
};

enum class OdometrySource {
  none,         ///< the log has no odometry
  odom_lines,   ///< ODOM (or Odometry) lines
  scan_fields,  ///< the odometry written with each scan
};

struct CarmenStatistics {
  std::size_t lines = 0;
  std::size_t scans = 0;           ///< in the recording
  std::size_t rear_scans = 0;      ///< in `rear_scans`
  std::size_t odometry = 0;        ///< in the recording
  std::size_t radar_scans = 0;     ///< in the recording, those without a point too
  std::size_t radar_points = 0;    ///< in the recording
  std::size_t wheels = 0;          ///< in the recording
  std::size_t gyro = 0;            ///< in the recording
  std::size_t true_poses = 0;      ///< in the recording
  std::size_t skipped_lines = 0;   ///< malformed, or out of order of time
  std::size_t invalid_ranges = 0;  ///< not finite or negative: taken as no return
  std::size_t invalid_points = 0;  ///< of radar lines, not finite: left out
  OdometrySource odometry_source = OdometrySource::none;
  /// The largest range that counts as a return lies below this, metres.
  float max_range_m = 0.0F;
  bool compressed = false;
  bool synthetic_time = false;               ///< the log has no time stamps
  std::map<std::string, std::size_t> other;  ///< lines not used, by their first word
};

struct CarmenLog {
  /// Front laser, odometry, radar, wheels, gyro and truth. Times are the log's IPC time stamps,
  /// exact to the nanosecond and not decreasing; equal stamps occur. Where lines are out of order
  /// the largest set that is in order is kept.
  Recording recording;
  /// The pose written with each scan, as it stands: of the laser by odometry in a raw log, of a
  /// corrected trajectory in a corrected one. One for each scan of the recording, or empty.
  Trajectory reported_poses;
  /// Scans of the rear laser, bearings from its own axis, which points backwards on the robot.
  std::vector<LaserScan> rear_scans;
  std::map<std::string, std::string> parameters;  ///< PARAM lines; the last value stands
  Problems problems;
  CarmenStatistics statistics;
};

/// Field of view: 180 or 181 beams are 1° apart from −90°, 360 or 361 are 0.5° apart; any other
/// number spans 180° (from −90°, step π/n, or π/(n−1) for odd n, which has a beam at +90°) unless
/// PARAM laser_frontlaser_fov and laser_frontlaser_resolution (degrees) say otherwise. ROBOTLASER
/// and RAWLASER lines carry their own.
///
/// Odometry: the ODOM lines where at least two are in order and they cover half the scans' time or
/// more; else the odometry written with the scans.
///
/// Of radar, wheels, gyro and truth a line with the time stamp of the one before repeats it: it is
/// reported and left out. PARAM robot_wheelbase, robot_radar_offset, robot_radar_side_offset and
/// robot_radar_angular_offset (metres and radians, from the robot's centre) say how they are
/// mounted.
///
/// A cut-off gzip file is read as far as it goes, with a problem. Errors: the file cannot be read,
/// or it holds no scan that can be used (with `needs_laser` off: nothing at all that can be used).
[[nodiscard]] Result<CarmenLog> read_carmen(const std::string& path,
                                            const CarmenOptions& options = {});
[[nodiscard]] Result<CarmenLog> parse_carmen(std::string_view text, const std::string& source,
                                             const CarmenOptions& options = {});

/// `recording` as a CARMEN log, all its streams in order of time: ODOM, WHEELS, GYRO, TRUEPOS and
/// RADAR lines and the scans, these with the odometry interpolated to them. A scan that a FLASER
/// line describes in full (half a turn from -90 deg in steps of 1 or 0.5 deg, the laser straight
/// ahead on the robot) becomes one, others become ROBOTLASER1. Numbers are written so that reading
/// them gives the same bits, times as exact seconds with nine decimals.
[[nodiscard]] std::string format_carmen(const Recording& recording);

[[nodiscard]] Result<void> write_carmen(const std::string& path, const Recording& recording,
                                        const WriteOptions& options = {});

}  // namespace wayfare::io
