#pragma once

// Data of inertial and satellite navigation as text columns: inertial samples, corrected ranges,
// fixes, and reference trajectories. Invalid lines are skipped and reported with their number.
// Plain or gzip.
//
// RTKLIB's time tags (FILE.tag): the arrival times of a logged stream's parts at the computer,
// which convert a stream without times, or with a device's counter, to GPS time.
//
// Recordings of nine-axis units as columns: text with named columns (text_file.hpp), or a binary
// table with column names from the caller. Plain or gzip.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sync/clock_fit.hpp>

namespace wayfare::io {

/// The end of a line in its file.
struct LineEnd {
  std::size_t line = 0;  ///< number, from 1
  std::size_t byte = 0;  ///< offset after the line
};

/// Columns gx gy gz and ax ay az; a file with only three of them is one part of a unit with
/// separate logs per sensor.
struct ImuFile {
  std::vector<ImuSample> samples;       ///< in the order of the file
  std::vector<LineEnd> ends;            ///< of the samples' lines
  bool has_gyro = false;                ///< columns gx gy gz
  bool has_accelerometer = false;       ///< columns ax ay az
  Problems problems;                    ///< lines skipped
  std::vector<ColumnUse> columns = {};  ///< as understood; none of a file without columns
};

/// Errors of these readers: the file cannot be read, a column is missing or has an unknown unit, or
/// no line is usable.
[[nodiscard]] Result<ImuFile> read_imu(const std::string& path, const ColumnFormat& format = {});
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<ImuFile> parse_imu(std::string_view text, const std::string& source,
                                        const ColumnFormat& format = {});

/// One sample per sample of `gyro`, with `accelerometer` interpolated to its times; samples outside
/// its range or in a gap longer than `max_gap` are dropped. Both in order of time.
[[nodiscard]] std::vector<ImuSample> merge_imu_parts(
    std::span<const ImuSample> gyro, std::span<const ImuSample> accelerometer,
    Duration max_gap = std::chrono::milliseconds(500));

/// A line per satellite: time, sat ("G05"), position x y z and velocity vx vy vz (Earth-fixed),
/// range and rate, range_sigma, rate_sigma, cn0, phase (in metres), phase_sigma, interrupted (1:
/// the phase may have jumped); "nan": not measured. Successive lines of one time are one epoch.
/// Without sigma columns CorrectedRange's defaults apply.
struct RangesFile {
  std::vector<RangeEpoch> epochs;       ///< in the order of the file
  Problems problems;                    ///< lines skipped
  std::vector<ColumnUse> columns = {};  ///< as understood; none of a file without columns
};

/// Errors as of read_imu.
[[nodiscard]] Result<RangesFile> read_ranges(const std::string& path,
                                             const ColumnFormat& format = {});
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<RangesFile> parse_ranges(std::string_view text, const std::string& source,
                                              const ColumnFormat& format = {});

/// Column speed: of a vehicle's wheels, negative backwards.
struct WheelsFile {
  std::vector<WheelSpeed> readings;     ///< in the order of the file
  Problems problems;                    ///< lines skipped
  std::vector<ColumnUse> columns = {};  ///< as understood; none of a file without columns
};

/// Errors as of read_imu.
[[nodiscard]] Result<WheelsFile> read_wheels(const std::string& path,
                                             const ColumnFormat& format = {});
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<WheelsFile> parse_wheels(std::string_view text, const std::string& source,
                                              const ColumnFormat& format = {});

/// Columns lat lon h; sn se sd (standard deviations), sne seu sun (signed roots of covariances, as
/// RTKLIB writes them); vn ve vd or vu; svn sve svd; sh and sv_h (horizontal and vertical accuracy)
/// instead of sn se sd; speed and course instead of vn ve; q (quality, RTKLIB's numbers). Or
/// Earth-fixed: ecef_x ecef_y ecef_z; ecef_sx …, ecef_sxy ecef_syz ecef_szx; ecef_vx ….
struct FixFile {
  std::vector<GnssFix> fixes;           ///< in the order of the file
  std::vector<int> qualities;           ///< of each fix; 0: not given
  Problems problems;                    ///< lines skipped
  std::vector<ColumnUse> columns = {};  ///< as understood; none of a file without columns
};

/// Also reads, recognised by their content where no columns are named: RTKLIB's .pos files
/// (geodetic in degrees, or Earth-fixed; by their '%' heading), GPX tracks, KML tracks with times,
/// and streams of a receiver with NAV-PVT messages of u-blox or NMEA sentences (GGA and RMC). The
/// standard deviations of NMEA fixes are 3 m (differential 1.5 m, float 0.3 m, fixed 0.02 m) times
/// the HDOP, of GPX and KML those of GnssFix. UTC becomes GPS time by the table of leap seconds.
[[nodiscard]] Result<FixFile> read_fixes(const std::string& path, const ColumnFormat& format = {});
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<FixFile> parse_fixes(std::string_view text, const std::string& source,
                                          const ColumnFormat& format = {});

/// Columns lat lon h; vn ve and vd or vu; roll pitch yaw. Or Earth-fixed: ecef_x …,
/// ecef_vx ….
struct NavFile {
  NavTrajectory trajectory;             ///< in the order of the file; missing quantities are zero
  bool has_velocity = false;            ///< columns vn ve
  bool has_attitude = false;            ///< columns roll pitch yaw
  Problems problems;                    ///< lines skipped
  std::vector<ColumnUse> columns = {};  ///< as understood; none of a file without columns
};

/// Also reads the other files that read_fixes does.
[[nodiscard]] Result<NavFile> read_nav(const std::string& path, const ColumnFormat& format = {});
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<NavFile> parse_nav(std::string_view text, const std::string& source,
                                        const ColumnFormat& format = {});

/// Stamps of the same instants on a device's clock (column device) and in GPS time, e.g. of a
/// phone's fixes.
struct ClockFile {
  std::vector<ClockPair<DeviceClock>> pairs;  ///< in the order of the file
  Problems problems;                          ///< lines skipped
  std::vector<ColumnUse> columns;             ///< as understood; none of a file without columns
};

/// Errors as of read_imu.
[[nodiscard]] Result<ClockFile> read_clock(const std::string& path,
                                           const ColumnFormat& format = {});
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<ClockFile> parse_clock(std::string_view text, const std::string& source,
                                            const ColumnFormat& format = {});

/// With named columns; numbers other than angles read back to the same bits.
[[nodiscard]] std::string format_imu(std::span<const ImuSample> samples);
[[nodiscard]] std::string format_ranges(std::span<const RangeEpoch> epochs);    ///< as format_imu
[[nodiscard]] std::string format_fixes(std::span<const GnssFix> fixes);         ///< as format_imu
[[nodiscard]] std::string format_wheels(std::span<const WheelSpeed> readings);  ///< as format_imu
[[nodiscard]] std::string format_nav(std::span<const NavState> trajectory);     ///< as format_imu

/// Errors: the file exists (see WriteOptions), or cannot be written.
[[nodiscard]] inline Result<void> write_imu(const std::string& path,
                                            std::span<const ImuSample> samples,
                                            const WriteOptions& options = {}) {
  return write_file(path, format_imu(samples), options);
}
/// Errors: the file exists (see WriteOptions), or cannot be written.
[[nodiscard]] inline Result<void> write_ranges(const std::string& path,
                                               std::span<const RangeEpoch> epochs,
                                               const WriteOptions& options = {}) {
  return write_file(path, format_ranges(epochs), options);
}
/// Errors: the file exists (see WriteOptions), or cannot be written.
[[nodiscard]] inline Result<void> write_fixes(const std::string& path,
                                              std::span<const GnssFix> fixes,
                                              const WriteOptions& options = {}) {
  return write_file(path, format_fixes(fixes), options);
}
/// Errors: the file exists (see WriteOptions), or cannot be written.
[[nodiscard]] inline Result<void> write_nav(const std::string& path,
                                            std::span<const NavState> trajectory,
                                            const WriteOptions& options = {}) {
  return write_file(path, format_nav(trajectory), options);
}

/// Errors: the file exists (see WriteOptions), or cannot be written.
[[nodiscard]] inline Result<void> write_wheels(const std::string& path,
                                               std::span<const WheelSpeed> readings,
                                               const WriteOptions& options = {}) {
  return write_file(path, format_wheels(readings), options);
}

/// At `time`, GPS time by the computer's clock, this number of bytes of the stream had arrived.
struct TimeTag {
  std::uint64_t bytes = 0;  ///< of the stream
  LogTime time;             ///< of arrival, GPS time
};

/// 64 bytes that begin with "TIMETAG RTKLIB", the last four of them the computer's tick; the start
/// as seconds since 1970 (uint32) and their fraction (double), GPS time; then records of the
/// milliseconds since the start and the bytes of the stream by then (uint32 both). Little endian.
struct TimeTagFile {
  std::vector<TimeTag> tags;  ///< times and bytes do not decrease
  Problems problems;          ///< records out of order, skipped
};

/// Errors: the file cannot be read, is not a time tag file, or contains no tag.
[[nodiscard]] Result<TimeTagFile> read_time_tags(const std::string& path);
/// The same for bytes in memory; `source` names them in messages.
[[nodiscard]] Result<TimeTagFile> parse_time_tags(std::string_view bytes,
                                                  const std::string& source);

/// The linear fit from the times of `file`, its device's own counter, to GPS time. Each sample is
/// paired with the first tag after its arrival. Streams logged with CR LF but stored with LF alone
/// are detected by the byte count of the last tag, which exceeds the file's size. Errors: samples
/// without `ends`, as from other kinds of files; fewer than two instants.
[[nodiscard]] Result<ClockFit<LogClock>> fit_time_tags(const ImuFile& file,
                                                       const TimeTagFile& tags);

/// The reference attitude of a sample, in the recording's world frame.
struct MargReference {
  SO3d q_world_body;   ///< body to world
  bool known = false;  ///< false where its fields are empty or NaN
};

/// A recording of a nine-axis unit.
struct MargFile {
  MargRecording samples;                 ///< in the order of the file; NaN: not measured
  std::vector<MargReference> reference;  ///< of each sample; empty without such columns
  std::vector<bool> moving;              ///< of each sample: column `moving`; true without it
  /// Air pressure at each sample, NaN: not measured; empty without column `p`.
  std::vector<double> pressure_Pa;
  bool has_magnetometer = false;  ///< columns mx my mz
  Problems problems;              ///< lines skipped
};

/// Columns and period of read_marg.
struct MargFormat {
  /// The columns gx gy gz, ax ay az (both needed), mx my mz (uT, nT, mT, T or G), qw qx qy qz,
  /// moving (0 or 1), p (Pa, hPa, mbar, kPa), and the time.
  ColumnFormat columns;
  /// Sampling period of a table without a time column, s; zero where it has one.
  double period_s = 0.0;
};

/// Errors: the file cannot be read, a column is missing or has an unknown unit, or no line is
/// usable; for a binary table also a wrong number of names, or a period that is negative or not
/// finite.
[[nodiscard]] Result<MargFile> read_marg(const std::string& path, const MargFormat& format = {});
/// The same for bytes in memory; `source` names them in messages.
[[nodiscard]] Result<MargFile> parse_marg(std::string_view bytes, const std::string& source,
                                          const MargFormat& format = {});

/// Text with named columns; without the magnetometer's columns where no sample has a field.
[[nodiscard]] std::string format_marg(std::span<const MargSample> samples);
/// Errors: the file exists (see WriteOptions), or cannot be written.
[[nodiscard]] inline Result<void> write_marg(const std::string& path,
                                             std::span<const MargSample> samples,
                                             const WriteOptions& options = {}) {
  return write_file(path, format_marg(samples), options);
}

/// Root mean squares of an estimator's errors over the moving samples with a reference.
template <AttitudeEstimator Estimator>
[[nodiscard]] eval::AttitudeError attitude_rmse(Estimator& estimator, const MargFile& file) {
  eval::AttitudeRmse rmse;
  for (std::size_t i = 0; i < file.samples.size(); ++i) {
    estimator.add(file.samples[i]);
    if (!estimator.ready() || !file.moving[i] || !file.reference[i].known) continue;
    rmse.add(eval::attitude_error(estimator.q_world_body().template cast<double>(),
                                  file.reference[i].q_world_body));
  }
  return rmse.value();
}

}  // namespace wayfare::io
