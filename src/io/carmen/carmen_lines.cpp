#include "io/carmen/carmen_lines.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
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

}  // namespace

Result<void> LineParser::ranges(text::Tokens& tokens, std::vector<float>& values) {
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

Result<void> LineParser::time_and_host(text::Tokens& tokens, bool terminated, LogTime& time) {
  const std::string_view stamp = tokens.next();
  const std::optional<LogTime> parsed = parse_stamp(stamp);
  if (!parsed) {
    return fault(stamp.empty() ? std::string("the line ends before the time stamp")
                               : "not a time stamp: '" + text::printable(stamp) +
                                     "' (is the number of ranges correct?)");
  }
  time = *parsed;
  const std::string_view host = tokens.next();
  const std::string_view logger_time = tokens.next();
  double number = 0.0;
  if (host.empty()) {
    if (host_seen_ && !terminated) return fault("the line ends within the time stamp");
    return {};
  }
  if (logger_time.empty() && text::to_number(host, number))
    return fault("a number where the host is expected: more fields than the line should have");
  if (!logger_time.empty() && !text::to_number(logger_time, number))
    return fault("not a logger time: '" + text::printable(logger_time) + "'");
  if (!tokens.at_end()) return fault("more fields than the line should have");
  host_seen_ = true;
  return {};
}

Result<ScanLine> LineParser::laser(text::Tokens tokens, bool terminated) {
  ScanLine result;
  double poses[6];
  Result<void> done = ranges(tokens, result.scan.ranges_m);
  if (done) done = numbers(tokens, poses, 6, "laser and robot pose");
  if (done) done = time_and_host(tokens, terminated, result.scan.time);
  if (!done) return done.error();
  result.laser_pose = pose(poses);
  result.robot_pose = pose(poses + 3);
  return result;
}

Result<ScanLine> LineParser::robot_laser(text::Tokens tokens, bool with_poses, bool terminated) {
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
  done = time_and_host(tokens, terminated, result.scan.time);
  if (!done) return done.error();
  return result;
}

Result<ScanLine> LineParser::bare_laser(text::Tokens tokens) {
  ScanLine result;
  const Result<void> done = ranges(tokens, result.scan.ranges_m);
  if (!done) return done.error();
  if (!tokens.at_end()) return fault("more fields than the line should have");
  return result;
}

template <std::size_t kNumbers, class Make>
auto LineParser::stamped(text::Tokens tokens, bool terminated, const char* what, const Make& make)
    -> Result<decltype(make(nullptr, LogTime()))> {
  double values[kNumbers];
  LogTime time;
  Result<void> done = numbers(tokens, values, kNumbers, what);
  if (done) done = time_and_host(tokens, terminated, time);
  if (!done) return done.error();
  return make(values, time);
}

Result<OdometrySample> LineParser::odom(text::Tokens tokens, bool terminated) {
  return stamped<6>(tokens, terminated, "pose, velocities and acceleration",
                    [](const double* v, LogTime time) {
                      return OdometrySample{time, Transform2<frame::Odom, frame::Base>(pose(v))};
                    });
}

Result<OdometrySample> LineParser::bare_odometry(text::Tokens tokens) {
  double values[3];
  const Result<void> done = numbers(tokens, values, 3, "x, y, heading");
  if (!done) return done.error();
  if (!tokens.at_end()) return fault("more fields than the line should have");
  return OdometrySample{{}, Transform2<frame::Odom, frame::Base>(pose(values))};
}

Result<RadarScan> LineParser::radar(text::Tokens tokens, bool terminated) {
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
  if (auto done = time_and_host(tokens, terminated, scan.time); !done) return done.error();
  return scan;
}

Result<WheelSample> LineParser::wheels(text::Tokens tokens, bool terminated) {
  return stamped<2>(tokens, terminated, "left and right wheel", [](const double* v, LogTime time) {
    return WheelSample{time, v[0], v[1]};
  });
}

Result<GyroSample> LineParser::gyro(text::Tokens tokens, bool terminated) {
  return stamped<1>(tokens, terminated, "turn rate", [](const double* v, LogTime time) {
    return GyroSample{time, v[0]};
  });
}

Result<StampedPose> LineParser::true_pose(text::Tokens tokens, bool terminated) {
  return stamped<6>(tokens, terminated, "true pose and pose by odometry",
                    [](const double* v, LogTime time) {
                      return StampedPose{time, Transform2<frame::Map, frame::Base>(pose(v))};
                    });
}

}  // namespace wayfare::io::carmen
