#include <wayfare/io/carmen.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <wayfare/io/text_file.hpp>

#include "io/carmen/carmen_clock.hpp"
#include "io/carmen/carmen_lines.hpp"
#include "io/text/lines.hpp"

namespace wayfare::io {
namespace {

using carmen::Faults;
using carmen::Measured;
using carmen::ScanLine;

template <class Line>
Error out_of_order(const Line& line, const std::vector<Line>& before, const char* what) {
  std::string message = std::string(what) + " is out of order: time stamp " +
                        format_nanoseconds(time_of(line).nanoseconds()) + " s";
  if (!before.empty())
    message += " after " + format_nanoseconds(time_of(before.back()).nanoseconds()) + " s";
  return Error{ErrorCode::invalid, std::move(message)};
}

template <class Line>
std::vector<LogTime> times_of(const std::vector<Line>& lines) {
  std::vector<LogTime> times;
  times.reserve(lines.size());
  for (const Line& line : lines) times.push_back(time_of(line));
  return times;
}

/// Drops every line that `repeats` the previous one kept.
template <class Line, class Repeats>
void drop_repetitions(std::vector<Line>& lines, const char* what, const Repeats& repeats,
                      Faults& faults) {
  std::vector<Line> kept;
  kept.reserve(lines.size());
  for (Line& line : lines) {
    if (kept.empty() || !repeats(line, kept.back())) {
      kept.push_back(std::move(line));
      continue;
    }
    const std::string first = std::to_string(kept.back().line);
    faults.skip(Error{ErrorCode::invalid, "repeats the " + std::string(what) + " of line " + first},
                line.line);
  }
  lines = std::move(kept);
}

bool same_scan(const ScanLine& a, const ScanLine& b) {
  const auto same = [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  const std::vector<float>&r = a.scan.ranges_m, &s = b.scan.ranges_m;
  return a.scan.time == b.scan.time && std::equal(r.begin(), r.end(), s.begin(), s.end(), same);
}

/// Of single scans a little out of order, which repeat no other; their number.
std::size_t interpolate_late(std::vector<ScanLine>& scans) {
  const auto late = carmen::times_of_late_lines(times_of(scans));
  std::size_t count = 0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const auto repeats = [&](const ScanLine& before) { return same_scan(scans[i], before); };
    const auto end = scans.begin() + static_cast<std::ptrdiff_t>(i);
    if (!late[i] || std::any_of(scans.begin(), end, repeats)) continue;
    scans[i].scan.time = *late[i];
    ++count;
  }
  return count;
}

/// Drops the smallest set of lines that are not in order of time and reports them; `what` names
/// such a line.
template <class Line>
void order(std::vector<Line>& lines, const char* what, Faults& faults) {
  const std::vector<bool> keep = carmen::largest_ordered_set(times_of(lines));
  std::vector<Line> kept;
  kept.reserve(lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (keep[i]) {
      kept.push_back(std::move(lines[i]));
    } else {
      faults.skip(out_of_order(lines[i], kept, what), lines[i].line);
    }
  }
  lines = std::move(kept);
}

std::vector<ScanLine>& most_frequent(carmen::ScansByKind& kinds) {
  return *std::max_element(kinds.begin(), kinds.end(),
                           [](const auto& a, const auto& b) { return a.size() < b.size(); });
}

bool covers_half(const std::vector<Measured<OdometrySample>>& lines,
                 const std::vector<LaserScan>& scans) {
  const LogTime first = scans.front().time, last = scans.back().time;
  const Duration overlap = std::min(lines.back().value.time, last).since_epoch() -
                           std::max(lines.front().value.time, first).since_epoch();
  return 2.0 * to_seconds(overlap) >= to_seconds(last - first);
}

/// In order of time, if many lines are not and no stamp is far outside the time of the scans: they
/// were written late. A single wrong stamp would put a pose at a wrong time.
void sort_shuffled(std::vector<Measured<OdometrySample>>& lines,
                   const std::vector<LaserScan>& scans) {
  if (lines.empty() || scans.empty()) return;
  const Duration slack = std::chrono::minutes(1);
  const LogTime first = scans.front().time - slack, last = scans.back().time + slack;
  std::size_t descents = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const LogTime t = lines[i].value.time;
    if (t < first || t > last) return;
    if (i > 0 && t < lines[i - 1].value.time) ++descents;
  }
  if (descents * 100 <= lines.size()) return;
  std::stable_sort(lines.begin(), lines.end(),
                   [](const auto& a, const auto& b) { return time_of(a) < time_of(b); });
}

template <class T>
std::vector<T> values_of(std::vector<Measured<T>>& lines) {
  std::vector<T> values;
  values.reserve(lines.size());
  for (Measured<T>& line : lines) values.push_back(std::move(line.value));
  return values;
}

/// The values in order of time, without duplicates: lines with the time of the previous one.
template <class T>
std::vector<T> ordered_once(std::vector<Measured<T>>& lines, const char* what, Faults& faults) {
  order(lines, what, faults);
  const auto at_the_same_time = [](const auto& a, const auto& b) {
    return time_of(a) == time_of(b);
  };
  drop_repetitions(lines, what, at_the_same_time, faults);
  return values_of(lines);
}

/// Converts text to a log: parses the lines, then combines them.
class CarmenReader {
 public:
  CarmenReader(const std::string& source, const CarmenOptions& options)
      : options_(options), faults_(source, log_), collector_(options, faults_, log_) {
    log_.problems = Problems(options.max_problems);
  }

  void report(Error error) { log_.problems.add(std::move(error)); }

  Result<CarmenLog> read(std::string_view all) {
    text::Lines lines(all);
    std::string with_points;
    for (std::string_view line; lines.next(line);) {
      if (line.find(',') != line.npos) line = with_points = text::with_decimal_points(line);
      collector_.take(line, lines.number(), lines.terminated());
    }
    log_.statistics.lines = lines.number();
    return finish();
  }

 private:
  Result<CarmenLog> finish() {
    std::vector<ScanLine>& scans = most_frequent(collector_.lines().front);
    const bool pairs = &scans == &collector_.lines().front[carmen::kPair];
    if (!pairs) repair_clock(scans);
    log_.rear_scans = finish_scans(most_frequent(collector_.lines().rear), "rear scan");
    log_.recording.scans = finish_scans(scans, "scan");
    log_.statistics.scans = log_.recording.scans.size();
    log_.statistics.rear_scans = log_.rear_scans.size();
    finish_robot();
    if (log_.recording.scans.empty() && (options_.needs_laser || empty())) return no_scans();
    if (pairs && !scans.empty()) log_.statistics.clock = ClockState::numbered;
    finish_odometry(
        pairs && !scans.empty() ? collector_.lines().pair_odometry : collector_.lines().odometry,
        scans, pairs);
    log_.recording.T_base_laser =
        Transform2<frame::Base, frame::Laser>(carmen::mounting(scans, parameters_));
    take_reported_poses(scans);
    return std::move(log_);
  }

  void repair_clock(const std::vector<ScanLine>& scans) {
    const carmen::ClockRepair repair =
        carmen::repair_clock(collector_.lines(), scans, options_.pair_period);
    log_.statistics.clock = repair.state;
    log_.statistics.clock_reason = repair.reason;
  }

  void add_clock_reason(const std::string& reason) {
    std::string& all = log_.statistics.clock_reason;
    all += (all.empty() ? "" : "; ") + reason;
  }

  [[nodiscard]] bool empty() const {
    const Recording& r = log_.recording;
    return r.radar.empty() && r.wheels.empty() && r.gyro.empty() && r.truth.empty();
  }

  /// Radar, wheels, gyro and truth.
  void finish_robot() {
    carmen::LogLines& lines = collector_.lines();
    Recording& to = log_.recording;
    to.radar = ordered_once(lines.radar, "radar scan", faults_);
    to.wheels = ordered_once(lines.wheels, "wheel sample", faults_);
    to.gyro = ordered_once(lines.gyro, "gyro sample", faults_);
    to.truth = ordered_once(lines.truth, "true pose", faults_);
    to.T_base_radar = Transform2<frame::Base, frame::Radar>(carmen::radar_mounting(parameters_));
    to.radar_max_speed_m_s = std::max(0.0, parameters_["robot_radar_max_speed"]);
    to.wheel_base_m = std::max(0.0, parameters_["robot_wheelbase"]);
    CarmenStatistics& count = log_.statistics;
    count.radar_scans = to.radar.size();
    for (const RadarScan& scan : to.radar) count.radar_points += scan.points.size();
    count.wheels = to.wheels.size();
    count.gyro = to.gyro.size();
    count.true_poses = to.truth.size();
  }

  std::vector<LaserScan> finish_scans(std::vector<ScanLine>& scans, const char* what) {
    if (const std::size_t late = interpolate_late(scans); late > 0)
      add_clock_reason("time stamps of " + std::to_string(late) + " of " +
                       std::to_string(scans.size()) + " " + what +
                       "s are a little out of order: their times are interpolated");
    order(scans, what, faults_);
    drop_repetitions(scans, "scan", same_scan, faults_);
    const float limit = carmen::range_limit(scans, parameters_, options_);
    const Duration beam = from_seconds(parameters_["laser_frontlaser_time_increment"]);
    std::vector<LaserScan> result;
    result.reserve(scans.size());
    for (ScanLine& line : scans) {
      LaserScan& scan = line.scan;
      if (!line.has_bearings) carmen::set_bearings(scan, parameters_);
      scan.min_range_m = options_.min_range_m;
      scan.time_increment = beam;
      const bool own = scan.max_range_m > 0.0F && scan.max_range_m < limit;
      if (!own) scan.max_range_m = limit;
      log_.statistics.max_range_m = std::max(log_.statistics.max_range_m, scan.max_range_m);
      result.push_back(std::move(scan));
    }
    return result;
  }

  /// From the odometry lines, or from the scans' fields if the lines cover less than half, or their
  /// times were not measured.
  void finish_odometry(std::vector<Measured<OdometrySample>>& lines,
                       const std::vector<ScanLine>& scans, bool pairs) {
    const bool fields = !scans.empty() && scans.front().robot_pose && !pairs;
    const ClockState clock = log_.statistics.clock;
    if (fields && (clock == ClockState::interpolated || clock == ClockState::numbered)) {
      lines.clear();
    } else {
      sort_shuffled(lines, log_.recording.scans);
    }
    order(lines, "odometry", faults_);
    if (lines.size() >= 2 && lines.front().value.time < lines.back().value.time &&
        (!fields || covers_half(lines, log_.recording.scans))) {
      log_.recording.odometry = values_of(lines);
      log_.statistics.odometry_source = OdometrySource::odom_lines;
    } else if (fields) {
      for (std::size_t i = 0; i < scans.size(); ++i)
        if (scans[i].robot_pose)
          log_.recording.odometry.push_back(
              {scan_time(i), Transform2<frame::Odom, frame::Base>(*scans[i].robot_pose)});
      log_.statistics.odometry_source = OdometrySource::scan_fields;
    }
    log_.statistics.odometry = log_.recording.odometry.size();
  }

  [[nodiscard]] LogTime scan_time(std::size_t i) const { return log_.recording.scans[i].time; }

  void take_reported_poses(const std::vector<ScanLine>& scans) {
    const bool posed = std::all_of(scans.begin(), scans.end(),
                                   [](const ScanLine& s) { return s.laser_pose.has_value(); });
    if (!posed) return;
    for (std::size_t i = 0; i < scans.size(); ++i) {
      log_.reported_poses.push_back(
          {scan_time(i), Transform2<frame::Map, frame::Base>(*scans[i].laser_pose)});
    }
  }

  [[nodiscard]] Error no_scans() const {
    const std::size_t lines = log_.statistics.lines;
    if (lines == 0 && log_.problems.empty())
      return Error{ErrorCode::parse, "is empty", faults_.source()};
    const char* wanted = options_.needs_laser ? "no usable laser scan in "
                                              : "no line of a robot's log (FLASER, RADAR, ...) in ";
    std::string message = wanted + std::to_string(lines) + " lines";
    if (log_.statistics.rear_scans != 0) message += " (only rear scans)";
    std::size_t line = 0;
    if (!log_.problems.first().empty()) {
      const Error& first = log_.problems.first().front();
      line = first.line;
      message += "; first problem: " + first.message;
    }
    return Error{ErrorCode::parse, std::move(message), faults_.source(), line};
  }

  CarmenOptions options_;
  CarmenLog log_;
  Faults faults_;
  carmen::LineCollector collector_;
  carmen::Parameters parameters_{log_.parameters};
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
  if (content->damage) reader.report(with_data_before(*content->damage));
  Result<CarmenLog> log = reader.read(content->bytes);
  if (log) log->statistics.compressed = content->was_gzip;
  return log;
}

}  // namespace wayfare::io
