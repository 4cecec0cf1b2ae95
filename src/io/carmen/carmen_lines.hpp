#pragma once

// Private: parses the lines of a CARMEN log and collects them by type; carmen.cpp combines them.
// And properties of the laser derived from a whole log.

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <wayfare/io/carmen.hpp>

#include "io/text/text.hpp"

namespace wayfare::io::carmen {

/// The scan of one line. Bearings are set only where the line contains them.
struct ScanLine {
  std::size_t line = 0;
  LaserScan scan;
  bool has_bearings = false;
  std::optional<SE2d> laser_pose;
  std::optional<SE2d> robot_pose;
  std::optional<LogTime> logger_time;
};

/// A measurement and its line number.
template <class T>
struct Measured {
  std::size_t line = 0;
  T value = {};
  std::optional<LogTime> logger_time = {};
};

inline LogTime& time_of(ScanLine& line) { return line.scan.time; }
inline LogTime time_of(const ScanLine& line) { return line.scan.time; }
template <class T>
LogTime& time_of(Measured<T>& line) {
  return line.value.time;
}
template <class T>
LogTime time_of(const Measured<T>& line) {
  return line.value.time;
}

/// Adds to a log's problems.
class Faults {
 public:
  Faults(std::string source, CarmenLog& log) : source_(std::move(source)), log_(log) {}

  /// Reports a problem of a line that is used.
  void note(Error error, std::size_t line) {
    error.source = source_;
    error.line = line;
    log_.problems.add(std::move(error));
  }
  /// Reports a problem of a line that is skipped.
  void skip(Error error, std::size_t line) {
    note(std::move(error), line);
    ++log_.statistics.skipped_lines;
  }

  [[nodiscard]] const std::string& source() const { return source_; }

 private:
  std::string source_;
  CarmenLog& log_;
};

/// Types of scan lines, in order of preference: a log with two types contains the same scans twice.
enum Kind : std::size_t { kRobotLaser, kFrontLaser, kRawLaser, kPair, kKinds };

using ScansByKind = std::array<std::vector<ScanLine>, kKinds>;

/// In the order of the file.
struct LogLines {
  ScansByKind front, rear;
  std::vector<Measured<OdometrySample>> odometry;
  std::vector<Measured<OdometrySample>> pair_odometry;  ///< of the `Odometry`/`Laser` pairs
  std::vector<Measured<RadarScan>> radar;
  std::vector<Measured<WheelSample>> wheels;
  std::vector<Measured<GyroSample>> gyro;
  std::vector<Measured<StampedPose>> truth;
};

/// Parses lines. Parameters and counts are added to the log directly.
class LineCollector {
 public:
  LineCollector(const CarmenOptions& options, Faults& faults, CarmenLog& log)
      : options_(options), faults_(faults), log_(log) {}

  /// `number` from 1; `terminated`: it ended in '\n'.
  void take(std::string_view line, std::size_t number, bool terminated);

  [[nodiscard]] LogLines& lines() { return lines_; }

 private:
  void take_scan(Result<ScanLine> scan, std::vector<ScanLine>& to);
  void take_radar(text::Tokens tokens);
  template <class T>
  void take_sample(Result<T> sample, std::vector<Measured<T>>& to);
  void take_bare_laser(text::Tokens tokens);
  void take_bare_odometry(text::Tokens tokens);
  void take_parameter(text::Tokens& tokens);
  void take_other(std::string_view tag);
  void skip(Error fault);
  void note_invalid(std::size_t count, const std::string& message, std::size_t& lines);

  // These parse a line after its first word; the caller adds line and source to an error.

  /// FLASER and RLASER.
  Result<ScanLine> laser(text::Tokens tokens);
  /// ROBOTLASER1 and 2 (`with_poses`), RAWLASER1 and 2.
  Result<ScanLine> robot_laser(text::Tokens tokens, bool with_poses);
  /// `Laser n r1..rn`, time left at zero.
  Result<ScanLine> bare_laser(text::Tokens tokens);
  Result<RadarScan> radar(text::Tokens tokens);
  /// `make(numbers, time)` of a line of numbers, `what`, and the time.
  template <std::size_t kNumbers, class Make>
  auto stamped(text::Tokens tokens, const char* what, const Make& make)
      -> Result<decltype(make(nullptr, LogTime()))>;
  Result<void> ranges(text::Tokens& tokens, std::vector<float>& values);
  Result<void> time_and_host(text::Tokens& tokens, LogTime& time);

  CarmenOptions options_;
  Faults& faults_;
  CarmenLog& log_;
  LogLines lines_;
  std::optional<Measured<OdometrySample>> bare_pose_;  // of the current pair
  int pairs_ = 0;
  std::size_t invalid_ranges_ = 0;  // of the last scan: not finite or negative, NaN in it
  std::size_t invalid_points_ = 0;  // of the last radar line: not finite, not in its scan
  std::size_t lines_with_invalid_ranges_ = 0;
  std::size_t lines_with_invalid_points_ = 0;
  std::size_t line_ = 0;
  std::optional<LogTime> logger_time_;  // of the last line with times
  bool terminated_ = true;
  bool host_seen_ = false;
};

/// The PARAM lines of a log, as numbers.
class Parameters {
 public:
  explicit Parameters(const std::map<std::string, std::string>& values) : values_(values) {}

  /// 0 where the name is missing or its value is not a finite number.
  [[nodiscard]] double operator[](const char* name) const;

 private:
  const std::map<std::string, std::string>& values_;
};

/// Bearings of a scan whose line has none: by the number of beams, or PARAM.
void set_bearings(LaserScan& scan, const Parameters& parameters);

/// Ranges of `scans` from here on mean "no return".
[[nodiscard]] float range_limit(const std::vector<ScanLine>& scans, const Parameters& parameters,
                                const CarmenOptions& options);

/// Mounting of the laser: from PARAM, or from the difference of laser and robot pose if constant.
[[nodiscard]] SE2d mounting(const std::vector<ScanLine>& scans, const Parameters& parameters);

/// Mounting of the radar, from PARAM.
[[nodiscard]] SE2d radar_mounting(const Parameters& parameters);

}  // namespace wayfare::io::carmen
