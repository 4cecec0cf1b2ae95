#include "io/carmen/carmen_lines.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "io/text/lines.hpp"

namespace wayfare::io::carmen {
namespace {

Error fault(std::string message) { return Error{ErrorCode::parse, std::move(message)}; }

Result<void> numbers(text::Tokens& tokens, double* values, std::size_t count, const char* what) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::string_view token = tokens.next();
    if (token.empty()) {
      return fault("the line ends where " + std::string(what) + " are expected (" +
                   std::to_string(i) + " of " + std::to_string(count) + " numbers found)");
    }
    if (!text::to_number(token, values[i]))
      return fault(std::string(what) + ": not a number: '" + text::printable(token) + "'");
    if (!std::isfinite(values[i]))
      return fault(std::string(what) + ": not finite: '" + text::printable(token) + "'");
  }
  return {};
}

SE2d pose(const double* v) { return SE2d(v[0], v[1], Angle::radians(v[2])); }

/// Non-finite numbers as printed by some libraries: 1.#QNAN, -1.#IND, 1.#INF.
bool is_not_finite_text(std::string_view token) { return token.find('#') != token.npos; }

Result<std::size_t> count(text::Tokens& tokens, const char* what) {
  const std::string_view token = tokens.next();
  std::size_t value = 0;
  if (text::to_number(token, value)) return value;
  return fault("expected the number of " + std::string(what) + ", found '" +
               text::printable(token) + "'");
}

/// Reads a radar point; false where it is not finite.
Result<bool> radar_point(text::Tokens& tokens, RadarPoint& point) {
  float* fields[] = {&point.x_m, &point.y_m, &point.z_m, &point.doppler_m_s, &point.snr_db};
  bool finite = true;
  for (float* field : fields) {
    const std::string_view token = tokens.next();
    if (token.empty()) return fault("the line ends within a point");
    *field = std::numeric_limits<float>::quiet_NaN();
    if (!text::to_number(token, *field) && !is_not_finite_text(token))
      return fault("a point's coordinate is not a number: '" + text::printable(token) + "'");
    finite = finite && std::isfinite(*field);
  }
  return finite;
}

/// Whether the step is valid: positive, beams within 360 degrees.
bool is_step(double step_rad, std::size_t beams) {
  if (beams == 1) return true;
  return step_rad > 0.0 && step_rad * static_cast<double>(beams - 1) < 2.01 * std::numbers::pi;
}

bool is_word(std::string_view tag) {
  if (tag.size() > 40) return false;
  return std::all_of(tag.begin(), tag.end(), [](char c) { return c > 0x20 && c < 0x7f; });
}

}  // namespace

Result<void> LineCollector::ranges(text::Tokens& tokens, std::vector<float>& values) {
  invalid_ranges_ = 0;
  const Result<std::size_t> n = count(tokens, "ranges");
  if (!n) return n.error();
  if (*n == 0) return fault("a scan of no beams");
  values.reserve(std::min<std::size_t>(*n, 4096));  // the count may be invalid
  for (std::size_t i = 0; i < *n; ++i) {
    const std::string_view token = tokens.next();
    if (token.empty()) {
      return fault("the line ends after " + std::to_string(i) + " of " + std::to_string(*n) +
                   " ranges");
    }
    float range = std::numeric_limits<float>::quiet_NaN();
    if (!text::to_number(token, range) && !is_not_finite_text(token)) {
      return fault("range " + std::to_string(i + 1) + " of " + std::to_string(*n) +
                   " is not a number: '" + text::printable(token) + "'");
    }
    if (!(range >= 0.0F && std::isfinite(range))) {
      range = std::numeric_limits<float>::quiet_NaN();
      ++invalid_ranges_;
    }
    values.push_back(range);
  }
  return {};
}

Result<void> LineCollector::time_and_host(text::Tokens& tokens, LogTime& time) {
  const std::string_view stamp = tokens.next();
  const std::optional<LogTime> parsed = parse_stamp(stamp);
  if (!parsed) {
    return fault(stamp.empty() ? std::string("the line ends before the time stamp")
                               : "not a time stamp: '" + text::printable(stamp) +
                                     "' (is the number of ranges correct?)");
  }
  time = *parsed;
  logger_time_.reset();
  const std::string_view host = tokens.next();
  const std::string_view logger_time = tokens.next();
  double number = 0.0;
  if (host.empty()) {
    if (host_seen_ && !terminated_) return fault("the line ends within the time stamp");
    return {};
  }
  if (logger_time.empty() && text::to_number(host, number))
    return fault("a number where the host is expected: more fields than the line should have");
  if (!logger_time.empty() && !text::to_number(logger_time, number))
    return fault("not a logger time: '" + text::printable(logger_time) + "'");
  if (!tokens.at_end()) return fault("more fields than the line should have");
  logger_time_ = parse_stamp(logger_time);
  host_seen_ = true;
  return {};
}

Result<ScanLine> LineCollector::laser(text::Tokens tokens) {
  ScanLine result;
  double poses[6];
  Result<void> done = ranges(tokens, result.scan.ranges_m);
  if (done) done = numbers(tokens, poses, 6, "laser and robot pose");
  if (done) done = time_and_host(tokens, result.scan.time);
  if (!done) return done.error();
  result.laser_pose = pose(poses);
  result.robot_pose = pose(poses + 3);
  return result;
}

Result<ScanLine> LineCollector::robot_laser(text::Tokens tokens, bool with_poses) {
  ScanLine result;
  double head[7];  // type, start angle, field of view, step, largest range, accuracy, remission
  Result<void> done = numbers(tokens, head, 7, "the laser's properties");
  if (done) done = ranges(tokens, result.scan.ranges_m);
  if (!done) return done.error();
  const std::size_t beams = result.scan.ranges_m.size();
  double step = head[3];
  if (!is_step(step, beams)) step = head[2] / static_cast<double>(beams - 1);
  if (!is_step(step, beams) || std::abs(head[1]) > 2.01 * std::numbers::pi)
    return fault("the laser's start angle, field of view and resolution are invalid");
  result.scan.first_bearing = Angle::radians(head[1]);
  result.scan.bearing_step = Angle::radians(step);
  result.has_bearings = true;
  if (head[4] > 0.5) result.scan.max_range_m = static_cast<float>(std::min(head[4], 1e6));
  const Result<std::size_t> remissions = count(tokens, "remissions");
  if (!remissions) return remissions.error();
  for (std::size_t i = 0; i < *remissions; ++i)
    if (tokens.next().empty()) return fault("the line ends within the remissions");
  if (with_poses) {
    double poses[11];
    done = numbers(tokens, poses, 11, "laser and robot pose, velocities and safety distances");
    if (!done) return done.error();
    result.laser_pose = pose(poses);
    result.robot_pose = pose(poses + 3);
  }
  done = time_and_host(tokens, result.scan.time);
  if (!done) return done.error();
  return result;
}

Result<ScanLine> LineCollector::bare_laser(text::Tokens tokens) {
  ScanLine result;
  const Result<void> done = ranges(tokens, result.scan.ranges_m);
  if (!done) return done.error();
  if (!tokens.at_end()) return fault("more fields than the line should have");
  return result;
}

template <std::size_t kNumbers, class Make>
auto LineCollector::stamped(text::Tokens tokens, const char* what, const Make& make)
    -> Result<decltype(make(nullptr, LogTime()))> {
  double values[kNumbers];
  LogTime time;
  Result<void> done = numbers(tokens, values, kNumbers, what);
  if (done) done = time_and_host(tokens, time);
  if (!done) return done.error();
  return make(values, time);
}

Result<RadarScan> LineCollector::radar(text::Tokens tokens) {
  invalid_points_ = 0;
  const Result<std::size_t> n = count(tokens, "points");
  if (!n) return n.error();
  RadarScan scan;
  scan.points.reserve(std::min<std::size_t>(*n, 1024));  // the count may be invalid
  for (std::size_t i = 0; i < *n; ++i) {
    RadarPoint point;
    const Result<bool> finite = radar_point(tokens, point);
    if (!finite) {
      return fault("point " + std::to_string(i + 1) + " of " + std::to_string(*n) + ": " +
                   finite.error().message);
    }
    if (*finite) {
      scan.points.push_back(point);
    } else {
      ++invalid_points_;
    }
  }
  if (auto done = time_and_host(tokens, scan.time); !done) return done.error();
  return scan;
}

void LineCollector::take(std::string_view line, std::size_t number, bool terminated) {
  line_ = number;
  terminated_ = terminated;
  text::Tokens tokens(line);
  const std::string_view tag = tokens.next();
  if (tag.empty() || tag[0] == '#') return;
  const bool rear = tag == "RLASER" || tag.back() == '2';
  ScansByKind& scans = rear ? lines_.rear : lines_.front;
  if (tag == "FLASER" || tag == "RLASER") {
    return take_scan(laser(tokens), scans[kFrontLaser]);
  }
  if (tag == "ROBOTLASER1" || tag == "ROBOTLASER2") {
    return take_scan(robot_laser(tokens, true), scans[kRobotLaser]);
  }
  if (tag == "RAWLASER1" || tag == "RAWLASER2") {
    return take_scan(robot_laser(tokens, false), scans[kRawLaser]);
  }
  if (tag == "ODOM") {
    const auto make = [](const double* v, LogTime time) {
      return OdometrySample{time, Transform2<frame::Odom, frame::Base>(pose(v))};
    };
    return take_sample(stamped<6>(tokens, "pose, velocities and acceleration", make),
                       lines_.odometry);
  }
  if (tag == "RADAR") return take_radar(tokens);
  if (tag == "WHEELS") {
    const auto make = [](const double* v, LogTime time) { return WheelSample{time, v[0], v[1]}; };
    return take_sample(stamped<2>(tokens, "left and right wheel", make), lines_.wheels);
  }
  if (tag == "GYRO") {
    const auto make = [](const double* v, LogTime time) { return GyroSample{time, v[0]}; };
    return take_sample(stamped<1>(tokens, "turn rate", make), lines_.gyro);
  }
  if (tag == "TRUEPOS") {
    const auto make = [](const double* v, LogTime time) {
      return StampedPose{time, Transform2<frame::Map, frame::Base>(pose(v))};
    };
    return take_sample(stamped<6>(tokens, "true pose and pose by odometry", make), lines_.truth);
  }
  if (tag == "Laser") return take_bare_laser(tokens);
  if (tag == "Odometry") return take_bare_odometry(tokens);
  if (tag == "PARAM") return take_parameter(tokens);
  take_other(tag);
}

void LineCollector::take_scan(Result<ScanLine> scan, std::vector<ScanLine>& to) {
  if (!scan) return skip(scan.error());
  log_.statistics.invalid_ranges += invalid_ranges_;
  note_invalid(invalid_ranges_,
               std::to_string(invalid_ranges_) + " of " +
                   std::to_string(scan->scan.ranges_m.size()) +
                   " ranges are negative or not finite; treated as no return",
               lines_with_invalid_ranges_);
  scan->line = line_;
  scan->logger_time = logger_time_;
  to.push_back(std::move(*scan));
}

void LineCollector::take_radar(text::Tokens tokens) {
  Result<RadarScan> scan = radar(tokens);
  if (scan) {
    log_.statistics.invalid_points += invalid_points_;
    note_invalid(invalid_points_,
                 std::to_string(invalid_points_) + " radar points are not finite; dropped",
                 lines_with_invalid_points_);
  }
  take_sample(std::move(scan), lines_.radar);
}

template <class T>
void LineCollector::take_sample(Result<T> sample, std::vector<Measured<T>>& to) {
  if (!sample) return skip(sample.error());
  to.push_back({line_, std::move(*sample), logger_time_});
}

void LineCollector::take_bare_laser(text::Tokens tokens) {
  const LogTime time = LogTime() + options_.pair_period * pairs_++;
  if (bare_pose_) {
    bare_pose_->value.time = time;
    lines_.pair_odometry.push_back(*bare_pose_);
  }
  Result<ScanLine> scan = bare_laser(tokens);
  if (scan) {
    scan->scan.time = time;
    if (bare_pose_) scan->robot_pose = scan->laser_pose = bare_pose_->value.T_odom_base.raw();
  }
  bare_pose_.reset();
  take_scan(std::move(scan), lines_.front[kPair]);
}

void LineCollector::take_bare_odometry(text::Tokens tokens) {
  double values[3];
  Result<void> done = numbers(tokens, values, 3, "x, y, heading");
  if (done && !tokens.at_end()) done = fault("more fields than the line should have");
  if (!done) return skip(done.error());
  bare_pose_ = {line_, {{}, Transform2<frame::Odom, frame::Base>(pose(values))}};
}

void LineCollector::take_parameter(text::Tokens& tokens) {
  constexpr std::size_t kMax = 10000;
  const std::string_view name = tokens.next();
  const std::string_view value = tokens.next();
  if (value.empty()) return skip(fault("PARAM without name and value"));
  if (log_.parameters.size() < kMax) log_.parameters[std::string(name)] = std::string(value);
}

void LineCollector::take_other(std::string_view tag) {
  constexpr std::size_t kMax = 64;
  if (!is_word(tag)) {
    return skip(fault("unreadable bytes: '" + text::printable(tag) + "'"));
  }
  auto& other = log_.statistics.other;
  const std::string key(tag);
  const bool room = other.size() < kMax || other.contains(key);
  ++other[room ? key : "(other)"];
}

void LineCollector::skip(Error fault) {
  if (!terminated_) fault.message = "the last line is cut off: " + fault.message;
  faults_.skip(std::move(fault), line_);
}

void LineCollector::note_invalid(std::size_t count, const std::string& message,
                                 std::size_t& lines) {
  // Logs that write NaN for every beam without a return must not hide other problems.
  constexpr std::size_t kLinesReported = 20;
  if (count == 0 || ++lines > kLinesReported) return;
  faults_.note(Error{ErrorCode::invalid, message}, line_);
}

}  // namespace wayfare::io::carmen
