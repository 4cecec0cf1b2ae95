#include <wayfare/io/carmen.hpp>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "io/carmen/carmen_faults.hpp"
#include "io/carmen/carmen_laser.hpp"
#include "io/carmen/carmen_order.hpp"
#include "io/carmen/line_collector.hpp"
#include "io/text/text.hpp"

namespace wayfare::io {
namespace {

using carmen::OdometryLine;
using carmen::ScanLine;

std::vector<ScanLine>& most_frequent(carmen::ScansByKind& kinds) {
  return *std::max_element(kinds.begin(), kinds.end(),
                           [](const auto& a, const auto& b) { return a.size() < b.size(); });
}

bool covers_half(const std::vector<OdometryLine>& lines, const std::vector<LaserScan>& scans) {
  const LogTime first = scans.front().time, last = scans.back().time;
  const Duration overlap = std::min(lines.back().time, last).since_epoch() -
                           std::max(lines.front().time, first).since_epoch();
  return 2.0 * to_seconds(overlap) >= to_seconds(last - first);
}

template <class T>
std::vector<T> values_of(std::vector<carmen::Measured<T>>& lines) {
  std::vector<T> values;
  values.reserve(lines.size());
  for (carmen::Measured<T>& line : lines) values.push_back(std::move(line.value));
  return values;
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
    if (all.substr(0, 3) == "\xef\xbb\xbf") all.remove_prefix(3);  // a byte order mark
    text::Lines lines(all);
    for (std::string_view line; lines.next(line);)
      collector_.take(line, lines.number(), lines.terminated());
    log_.statistics.lines = lines.number();
    return finish();
  }

 private:
  Result<CarmenLog> finish() {
    std::vector<ScanLine>& scans = most_frequent(collector_.lines().front);
    const bool pairs = &scans == &collector_.lines().front[carmen::kPair];
    log_.rear_scans = finish_scans(most_frequent(collector_.lines().rear), "rear scan");
    log_.recording.scans = finish_scans(scans, "scan");
    log_.statistics.scans = log_.recording.scans.size();
    log_.statistics.rear_scans = log_.rear_scans.size();
    finish_robot();
    if (log_.recording.scans.empty() && (options_.needs_laser || empty())) return no_scans();
    log_.statistics.synthetic_time = pairs && !scans.empty();
    finish_odometry(
        pairs && !scans.empty() ? collector_.lines().pair_odometry : collector_.lines().odometry,
        scans, pairs);
    log_.recording.T_base_laser =
        Transform2<frame::Base, frame::Laser>(carmen::mounting(scans, parameters_));
    take_reported_poses(scans);
    return std::move(log_);
  }

  [[nodiscard]] bool empty() const {
    const Recording& r = log_.recording;
    return r.radar.empty() && r.wheels.empty() && r.gyro.empty() && r.truth.empty();
  }

  /// Radar, wheels, gyro and truth.
  void finish_robot() {
    carmen::LogLines& lines = collector_.lines();
    carmen::order_once(lines.radar, "radar scan", faults_);
    carmen::order_once(lines.wheels, "wheel sample", faults_);
    carmen::order_once(lines.gyro, "gyro sample", faults_);
    carmen::order_once(lines.truth, "true pose", faults_);
    Recording& to = log_.recording;
    to.radar = values_of(lines.radar);
    to.wheels = values_of(lines.wheels);
    to.gyro = values_of(lines.gyro);
    to.truth = values_of(lines.truth);
    to.T_base_radar = Transform2<frame::Base, frame::Radar>(carmen::radar_mounting(parameters_));
    to.radar_max_speed_m_s = std::max(0.0, parameters_["robot_radar_max_speed"]);
    to.wheel_base_m = std::max(0.0, parameters_["robot_wheelbase"]);
    count_robot(to);
  }

  void count_robot(const Recording& recording) {
    CarmenStatistics& to = log_.statistics;
    to.radar_scans = recording.radar.size();
    for (const RadarScan& scan : recording.radar) to.radar_points += scan.points.size();
    to.wheels = recording.wheels.size();
    to.gyro = recording.gyro.size();
    to.true_poses = recording.truth.size();
  }

  std::vector<LaserScan> finish_scans(std::vector<ScanLine>& scans, const char* what) {
    carmen::order(scans, what, faults_);
    carmen::drop_repeated(scans, faults_);
    const float limit = carmen::range_limit(scans, parameters_, options_);
    std::vector<LaserScan> result;
    result.reserve(scans.size());
    for (ScanLine& line : scans) {
      LaserScan& scan = line.scan;
      if (!line.has_bearings) carmen::set_bearings(scan, parameters_);
      scan.min_range_m = options_.min_range_m;
      const bool own = scan.max_range_m > 0.0F && scan.max_range_m < limit;
      if (!own) scan.max_range_m = limit;
      log_.statistics.max_range_m = std::max(log_.statistics.max_range_m, scan.max_range_m);
      result.push_back(std::move(scan));
    }
    return result;
  }

  /// From the odometry lines, or from the scans' fields if the lines cover less than half.
  void finish_odometry(std::vector<OdometryLine>& lines, const std::vector<ScanLine>& scans,
                       bool pairs) {
    carmen::order(lines, "odometry", faults_);
    const bool fields = !scans.empty() && scans.front().robot_pose && !pairs;
    if (lines.size() >= 2 && lines.front().time < lines.back().time &&
        (!fields || covers_half(lines, log_.recording.scans))) {
      for (const OdometryLine& line : lines) add_odometry(line.time, line.pose);
      log_.statistics.odometry_source = OdometrySource::odom_lines;
    } else if (fields) {
      for (std::size_t i = 0; i < scans.size(); ++i)
        if (scans[i].robot_pose) add_odometry(scan_time(i), *scans[i].robot_pose);
      log_.statistics.odometry_source = OdometrySource::scan_fields;
    }
    log_.statistics.odometry = log_.recording.odometry.size();
  }

  [[nodiscard]] LogTime scan_time(std::size_t i) const { return log_.recording.scans[i].time; }

  void add_odometry(LogTime time, const SE2d& pose) {
    log_.recording.odometry.push_back({time, Transform2<frame::Odom, frame::Base>(pose)});
  }

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
    std::string message =
        "no usable laser scan in " + std::to_string(log_.statistics.lines) + " lines";
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
  carmen::Faults faults_;
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
  if (content->damage) reader.report(*content->damage);
  Result<CarmenLog> log = reader.read(content->bytes);
  if (log) log->statistics.compressed = content->was_gzip;
  return log;
}

}  // namespace wayfare::io
