#include <wayfare/io/carmen.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include <wayfare/io/time_text.hpp>

#include "carmen_lines.hpp"
#include "text.hpp"

namespace wayfare::io {
namespace {

using carmen::OdometryLine;
using carmen::ScanLine;

/// Kinds of front scans, the preferred first: a log that has two gives the same scans twice.
enum Kind : std::size_t { kRobotLaser, kFrontLaser, kRawLaser, kPair, kKinds };

/// Which of `times` to keep: the largest set that does not decrease (a longest non-decreasing
/// subsequence by patience sorting), so that one absurd stamp costs one line and not all after it.
std::vector<bool> largest_ordered_set(const std::vector<std::int64_t>& times) {
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> tails, previous(times.size(), kNone);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto place =
        std::upper_bound(tails.begin(), tails.end(), times[i],
                         [&](std::int64_t t, std::size_t tail) { return t < times[tail]; });
    if (place != tails.begin()) previous[i] = *(place - 1);
    if (place == tails.end()) {
      tails.push_back(i);
    } else {
      *place = i;
    }
  }
  std::vector<bool> keep(times.size(), false);
  for (std::size_t i = tails.empty() ? kNone : tails.back(); i != kNone; i = previous[i])
    keep[i] = true;
  return keep;
}

LogTime time_of(const ScanLine& line) { return line.scan.time; }
LogTime time_of(const OdometryLine& line) { return line.time; }

bool is_word(std::string_view tag) {
  if (tag.size() > 40) return false;
  return std::all_of(tag.begin(), tag.end(), [](char c) { return c > 0x20 && c < 0x7f; });
}

bool same_ranges(const LaserScan& a, const LaserScan& b) {
  const auto same = [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  return std::equal(a.ranges_m.begin(), a.ranges_m.end(), b.ranges_m.begin(), b.ranges_m.end(),
                    same);
}

class CarmenReader {
 public:
  CarmenReader(std::string source, const CarmenOptions& options)
      : source_(std::move(source)), options_(options) {
    log_.problems = Problems(options.max_problems);
  }

  void report(Error error) { log_.problems.add(std::move(error)); }

  Result<CarmenLog> read(std::string_view all) {
    if (all.substr(0, 3) == "\xef\xbb\xbf") all.remove_prefix(3);  // a byte order mark
    text::Lines lines(all);
    for (std::string_view line; lines.next(line);) {
      line_ = lines.number();
      terminated_ = lines.terminated();
      take_line(line);
    }
    log_.statistics.lines = lines.number();
    return finish();
  }

 private:
  void skip(Error error, std::size_t line) {
    error.source = source_;
    error.line = line;
    report(std::move(error));
    ++log_.statistics.skipped_lines;
  }

  void take_line(std::string_view line) {
    text::Tokens tokens(line);
    const std::string_view tag = tokens.next();
    if (tag.empty() || tag[0] == '#') return;
    if (tag == "FLASER") return take_scan(parser_.laser(tokens, terminated_), front_[kFrontLaser]);
    if (tag == "ODOM") return take_odometry(parser_.odom(tokens, terminated_));
    if (tag == "RLASER") return take_scan(parser_.laser(tokens, terminated_), rear_[kFrontLaser]);
    if (tag == "ROBOTLASER1" || tag == "ROBOTLASER2") {
      auto& to = tag.back() == '1' ? front_ : rear_;
      return take_scan(parser_.robot_laser(tokens, true, terminated_), to[kRobotLaser]);
    }
    if (tag == "RAWLASER1" || tag == "RAWLASER2") {
      auto& to = tag.back() == '1' ? front_ : rear_;
      return take_scan(parser_.robot_laser(tokens, false, terminated_), to[kRawLaser]);
    }
    if (tag == "Laser") return take_bare_laser(tokens);
    if (tag == "Odometry") return take_bare_odometry(tokens);
    if (tag == "PARAM") return take_parameter(tokens);
    take_other(tag);
  }

  void take_fault(const Error& error) {
    Error fault = error;
    if (!terminated_) fault.message = "the last line is cut off: " + fault.message;
    skip(std::move(fault), line_);
  }

  void take_scan(Result<ScanLine> scan, std::vector<ScanLine>& to) {
    if (!scan) return take_fault(scan.error());
    report_invalid_ranges(scan->scan.ranges_m.size());
    scan->line = line_;
    to.push_back(std::move(*scan));
  }

  void report_invalid_ranges(std::size_t beams) {
    const std::size_t count = parser_.invalid_ranges();
    if (count == 0) return;
    log_.statistics.invalid_ranges += count;
    // Logs that write NaN for every beam without a return must not drown other problems.
    constexpr std::size_t kLinesReported = 20;
    if (++lines_with_invalid_ranges_ > kLinesReported) return;
    report(Error{ErrorCode::invalid,
                 std::to_string(count) + " of " + std::to_string(beams) +
                     " ranges are negative or not finite; taken as no return",
                 source_, line_});
  }

  void take_odometry(Result<OdometryLine> odometry) {
    if (!odometry) return take_fault(odometry.error());
    odometry->line = line_;
    odometry_.push_back(*odometry);
  }

  void take_bare_laser(text::Tokens tokens) {
    const LogTime time = LogTime() + options_.pair_period * pairs_++;
    if (bare_pose_) {
      bare_pose_->time = time;
      pair_odometry_.push_back(*bare_pose_);
    }
    Result<ScanLine> scan = parser_.bare_laser(tokens);
    if (scan) {
      scan->scan.time = time;
      if (bare_pose_) scan->robot_pose = scan->laser_pose = bare_pose_->pose;
    }
    bare_pose_.reset();
    take_scan(std::move(scan), front_[kPair]);
  }

  void take_bare_odometry(text::Tokens tokens) {
    const Result<OdometryLine> odometry = parser_.bare_odometry(tokens);
    if (!odometry) return take_fault(odometry.error());
    bare_pose_ = *odometry;
    bare_pose_->line = line_;
  }

  void take_parameter(text::Tokens& tokens) {
    const std::string_view name = tokens.next();
    const std::string_view value = tokens.next();
    if (value.empty()) return take_fault(Error{ErrorCode::parse, "PARAM without name and value"});
    constexpr std::size_t kMost = 10000;
    if (log_.parameters.size() < kMost) log_.parameters[std::string(name)] = std::string(value);
  }

  void take_other(std::string_view tag) {
    if (!is_word(tag)) {
      return take_fault(
          Error{ErrorCode::parse, "unreadable bytes: '" + text::printable(tag) + "'"});
    }
    constexpr std::size_t kMost = 64;
    const bool room = log_.statistics.other.size() < kMost;
    const std::string key(tag);
    if (room || log_.statistics.other.contains(key)) {
      ++log_.statistics.other[key];
    } else {
      ++log_.statistics.other["(other)"];
    }
  }

  /// Leaves out the lines that are not in order of time, and reports them.
  template <class Line>
  void order(std::vector<Line>& lines, const char* what) {
    std::vector<std::int64_t> times;
    times.reserve(lines.size());
    for (const Line& line : lines) times.push_back(time_of(line).nanoseconds());
    const std::vector<bool> keep = largest_ordered_set(times);
    std::vector<Line> kept;
    kept.reserve(lines.size());
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (keep[i]) {
        kept.push_back(std::move(lines[i]));
        continue;
      }
      std::string message =
          std::string(what) + " is out of order: time stamp " + format_nanoseconds(times[i]) + " s";
      if (!kept.empty())
        message += " after " + format_nanoseconds(time_of(kept.back()).nanoseconds()) + " s";
      skip(Error{ErrorCode::invalid, std::move(message)}, lines[i].line);
    }
    lines = std::move(kept);
  }

  void drop_repeated(std::vector<ScanLine>& scans) {
    std::vector<ScanLine> kept;
    kept.reserve(scans.size());
    for (ScanLine& scan : scans) {
      if (!kept.empty() && kept.back().scan.time == scan.scan.time &&
          same_ranges(kept.back().scan, scan.scan)) {
        skip(Error{ErrorCode::invalid,
                   "repeats the scan of line " + std::to_string(kept.back().line)},
             scan.line);
        continue;
      }
      kept.push_back(std::move(scan));
    }
    scans = std::move(kept);
  }

  std::optional<double> parameter(const char* name) const {
    const auto found = log_.parameters.find(name);
    double value = 0.0;
    if (found == log_.parameters.end() || !text::to_number(found->second, value))
      return std::nullopt;
    return std::isfinite(value) ? std::optional(value) : std::nullopt;
  }

  void set_bearings(LaserScan& scan) const {
    const std::size_t n = scan.ranges_m.size();
    const double beams = static_cast<double>(n);
    double fov_deg = 180.0;
    double step_deg = n % 2 == 1 ? 180.0 / std::max(beams - 1.0, 1.0) : 180.0 / beams;
    const bool usual = n == 180 || n == 181 || n == 360 || n == 361;
    const double fov = parameter("laser_frontlaser_fov").value_or(0.0);
    const double step = parameter("laser_frontlaser_resolution").value_or(0.0);
    if (!usual && step > 0.0 && step * (beams - 1.0) <= 361.0) {
      step_deg = step;
      fov_deg = n % 2 == 1 ? step * (beams - 1.0) : step * beams;
    } else if (!usual && fov > 0.0 && fov <= 360.0) {
      step_deg *= fov / 180.0;
    }
    if (!usual && fov > 0.0 && fov <= 360.0) fov_deg = fov;
    if (n == 1) fov_deg = 0.0;
    scan.first_bearing = Angle::degrees(-0.5 * fov_deg);
    scan.bearing_step = Angle::degrees(step_deg);
  }

  /// The range a log writes where nothing came back, if it is below `limit`; else `limit`.
  float no_return_value(const std::vector<ScanLine>& scans, float limit) const {
    float largest = 0.0F;
    std::size_t beams = 0;
    for (const ScanLine& scan : scans) {
      beams += scan.scan.ranges_m.size();
      for (const float r : scan.scan.ranges_m)
        if (r < limit) largest = std::max(largest, r);
    }
    std::vector<float> top;  // everything near the largest, by value
    for (const ScanLine& scan : scans)
      for (const float r : scan.scan.ranges_m)
        if (r >= 0.98F * largest && r < limit) top.push_back(r);
    std::sort(top.begin(), top.end());
    std::size_t best_begin = 0, best_count = 0;
    for (std::size_t i = 0; i < top.size();) {
      std::size_t end = i;
      // Logs printed from floats give one code as 8.183000 and 8.183001: half a millimetre is
      // equal.
      while (end < top.size() && top[end] - top[i] < 5e-4F) ++end;
      if (end - i > best_count) best_begin = i, best_count = end - i;
      i = end;
    }
    // A wall is seen at many distances; a code at one. `best_begin` counts what lies just below.
    constexpr std::size_t kFewestBeams = 10000;
    const bool frequent = best_count * 1000 >= beams && beams >= kFewestBeams;
    if (frequent && best_count * 10 <= beams * 9 && best_begin * 10 <= best_count)
      return top[best_begin];
    return limit;
  }

  float range_limit(const std::vector<ScanLine>& scans) const {
    float limit = options_.max_range_m;
    for (const char* name : {"laser_frontlaser_maxrange", "laser_frontlaser_max_range",
                             "laser_laser1_maxrange", "laser_laser1_max_range"}) {
      const double value = parameter(name).value_or(0.0);
      if (value > 0.5) limit = std::min(limit, static_cast<float>(std::min(value, 1e6)));
    }
    return options_.find_no_return_value ? no_return_value(scans, limit) : limit;
  }

  std::vector<LaserScan> finish_scans(std::vector<ScanLine>& scans, const char* what) {
    order(scans, what);
    drop_repeated(scans);
    const float limit = range_limit(scans);
    std::vector<LaserScan> result;
    result.reserve(scans.size());
    for (ScanLine& line : scans) {
      LaserScan& scan = line.scan;
      if (!line.has_bearings) set_bearings(scan);
      scan.min_range_m = options_.min_range_m;
      const bool own = scan.max_range_m > 0.0F && scan.max_range_m < limit;
      if (!own) scan.max_range_m = limit;
      log_.statistics.max_range_m = std::max(log_.statistics.max_range_m, scan.max_range_m);
      result.push_back(std::move(scan));
    }
    return result;
  }

  static std::vector<ScanLine>& most_frequent(std::array<std::vector<ScanLine>, kKinds>& kinds) {
    return *std::max_element(kinds.begin(), kinds.end(),
                             [](const auto& a, const auto& b) { return a.size() < b.size(); });
  }

  /// Where the laser sits: PARAM, or a difference of laser and robot pose that never changes.
  SE2d mounting(const std::vector<ScanLine>& scans) const {
    const double offset = parameter("robot_frontlaser_offset").value_or(0.0);
    const double side = parameter("robot_frontlaser_side_offset").value_or(0.0);
    if (offset != 0.0 || side != 0.0) return SE2d(offset, side, Angle());
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::optional<SE2d> first;
    for (const ScanLine& line : scans) {
      if (!line.laser_pose || !line.robot_pose) return {};
      const SE2d relative = line.robot_pose->inverse() * *line.laser_pose;
      if (!first) first = relative;
      const Eigen::Vector3d change = relative.minus(*first);
      if (change.cwiseAbs().maxCoeff() > 2e-3) return {};
      sum += change;
    }
    if (!first || first->log().norm() < 2e-3 || first->translation().norm() > 5.0) return {};
    return first->plus(sum / static_cast<double>(scans.size()));
  }

  void finish_odometry(const std::vector<ScanLine>& scans, const std::vector<LogTime>& times) {
    const bool pairs = &scans == &front_[kPair];
    std::vector<OdometryLine>& lines = pairs ? pair_odometry_ : odometry_;
    order(lines, "odometry");
    std::vector<OdometrySample>& to = log_.recording.odometry;
    const auto add = [&](LogTime time, const SE2d& pose) {
      to.push_back({time, Transform2<frame::Odom, frame::Base>(pose)});
    };
    const bool fields = !scans.empty() && scans.front().robot_pose && !pairs;
    if (lines.size() >= 2 && lines.front().time < lines.back().time &&
        (!fields || covers_half(lines, times))) {
      for (const OdometryLine& line : lines) add(line.time, line.pose);
      log_.statistics.odometry_source = OdometrySource::odom_lines;
    } else if (fields) {
      for (std::size_t i = 0; i < scans.size(); ++i)
        if (scans[i].robot_pose) add(times[i], *scans[i].robot_pose);
      log_.statistics.odometry_source = OdometrySource::scan_fields;
    }
    log_.statistics.odometry = to.size();
  }

  static bool covers_half(const std::vector<OdometryLine>& lines,
                          const std::vector<LogTime>& times) {
    const Duration overlap = std::min(lines.back().time, times.back()).since_epoch() -
                             std::max(lines.front().time, times.front()).since_epoch();
    return 2.0 * to_seconds(overlap) >= to_seconds(times.back() - times.front());
  }

  Result<CarmenLog> finish() {
    std::vector<ScanLine>& scans = most_frequent(front_);
    log_.rear_scans = finish_scans(most_frequent(rear_), "rear scan");
    log_.recording.scans = finish_scans(scans, "scan");
    log_.statistics.scans = log_.recording.scans.size();
    log_.statistics.rear_scans = log_.rear_scans.size();
    if (log_.recording.scans.empty()) return no_scans();
    log_.statistics.synthetic_time = &scans == &front_[kPair];
    std::vector<LogTime> times;
    for (const LaserScan& scan : log_.recording.scans) times.push_back(scan.time);
    finish_odometry(scans, times);
    log_.recording.T_base_laser = Transform2<frame::Base, frame::Laser>(mounting(scans));
    const bool posed = std::all_of(scans.begin(), scans.end(),
                                   [](const ScanLine& s) { return s.laser_pose.has_value(); });
    for (std::size_t i = 0; posed && i < scans.size(); ++i) {
      log_.reported_poses.push_back(
          {times[i], Transform2<frame::Map, frame::Base>(*scans[i].laser_pose)});
    }
    return std::move(log_);
  }

  Error no_scans() const {
    std::string message =
        "no laser scan that can be used in " + std::to_string(log_.statistics.lines) + " lines";
    if (log_.statistics.rear_scans != 0) message += " (only rear scans)";
    std::size_t line = 0;
    if (!log_.problems.empty()) {
      const Error& first = log_.problems.first().front();
      line = first.line;
      message += "; first problem: " + first.message;
    }
    return Error{ErrorCode::parse, std::move(message), source_, line};
  }

  std::string source_;
  CarmenOptions options_;
  CarmenLog log_;
  carmen::LineParser parser_;
  std::array<std::vector<ScanLine>, kKinds> front_, rear_;
  std::vector<OdometryLine> odometry_, pair_odometry_;
  std::optional<OdometryLine> bare_pose_;
  int pairs_ = 0;
  std::size_t lines_with_invalid_ranges_ = 0;
  std::size_t line_ = 0;
  bool terminated_ = true;
};

}  // namespace

Result<CarmenLog> parse_carmen(std::string_view text, const std::string& source,
                               const CarmenOptions& options) {
  return CarmenReader(source, options).read(text);
}

Result<CarmenLog> read_carmen(const std::string& path, const CarmenOptions& options) {
  const Result<FileContent> content = read_file(path, options.file);
  if (!content) return content.error();
  CarmenReader reader(path, options);
  if (content->damage) reader.report(*content->damage);
  Result<CarmenLog> log = reader.read(content->bytes);
  if (log) log->statistics.compressed = content->was_gzip;
  return log;
}

}  // namespace wayfare::io
