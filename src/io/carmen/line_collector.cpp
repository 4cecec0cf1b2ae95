#include "io/carmen/line_collector.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace wayfare::io::carmen {
namespace {

bool is_word(std::string_view tag) {
  if (tag.size() > 40) return false;
  return std::all_of(tag.begin(), tag.end(), [](char c) { return c > 0x20 && c < 0x7f; });
}

}  // namespace

void LineCollector::take(std::string_view line, std::size_t number, bool terminated) {
  line_ = number;
  terminated_ = terminated;
  text::Tokens tokens(line);
  const std::string_view tag = tokens.next();
  if (tag.empty() || tag[0] == '#') return;
  const bool rear = tag == "RLASER" || tag.back() == '2';
  ScansByKind& scans = rear ? lines_.rear : lines_.front;
  if (tag == "FLASER" || tag == "RLASER") {
    return take_scan(parser_.laser(tokens, terminated), scans[kFrontLaser]);
  }
  if (tag == "ROBOTLASER1" || tag == "ROBOTLASER2") {
    return take_scan(parser_.robot_laser(tokens, true, terminated), scans[kRobotLaser]);
  }
  if (tag == "RAWLASER1" || tag == "RAWLASER2") {
    return take_scan(parser_.robot_laser(tokens, false, terminated), scans[kRawLaser]);
  }
  if (tag == "ODOM") return take_sample(parser_.odom(tokens, terminated), lines_.odometry);
  if (tag == "RADAR") return take_radar(tokens);
  if (tag == "WHEELS") return take_sample(parser_.wheels(tokens, terminated), lines_.wheels);
  if (tag == "GYRO") return take_sample(parser_.gyro(tokens, terminated), lines_.gyro);
  if (tag == "TRUEPOS") return take_sample(parser_.true_pose(tokens, terminated), lines_.truth);
  if (tag == "Laser") return take_bare_laser(tokens);
  if (tag == "Odometry") return take_bare_odometry(tokens);
  if (tag == "PARAM") return take_parameter(tokens);
  take_other(tag);
}

void LineCollector::take_scan(Result<ScanLine> scan, std::vector<ScanLine>& to) {
  if (!scan) return skip(scan.error());
  note_invalid_ranges(scan->scan.ranges_m.size());
  scan->line = line_;
  to.push_back(std::move(*scan));
}

void LineCollector::take_radar(text::Tokens tokens) {
  Result<RadarScan> scan = parser_.radar(tokens, terminated_);
  if (scan) {
    const std::size_t count = parser_.invalid_points();
    log_.statistics.invalid_points += count;
    note_invalid(count, std::to_string(count) + " radar points are not finite; dropped",
                 lines_with_invalid_points_);
  }
  take_sample(std::move(scan), lines_.radar);
}

template <class T>
void LineCollector::take_sample(Result<T> sample, std::vector<Measured<T>>& to) {
  if (!sample) return skip(sample.error());
  to.push_back({line_, std::move(*sample)});
}

void LineCollector::take_bare_laser(text::Tokens tokens) {
  const LogTime time = LogTime() + options_.pair_period * pairs_++;
  if (bare_pose_) {
    bare_pose_->value.time = time;
    lines_.pair_odometry.push_back(*bare_pose_);
  }
  Result<ScanLine> scan = parser_.bare_laser(tokens);
  if (scan) {
    scan->scan.time = time;
    if (bare_pose_) scan->robot_pose = scan->laser_pose = bare_pose_->value.T_odom_base.raw();
  }
  bare_pose_.reset();
  take_scan(std::move(scan), lines_.front[kPair]);
}

void LineCollector::take_bare_odometry(text::Tokens tokens) {
  const Result<OdometrySample> odometry = LineParser::bare_odometry(tokens);
  if (!odometry) return skip(odometry.error());
  bare_pose_ = {line_, *odometry};
}

void LineCollector::take_parameter(text::Tokens& tokens) {
  constexpr std::size_t kMax = 10000;
  const std::string_view name = tokens.next();
  const std::string_view value = tokens.next();
  if (value.empty()) return skip(Error{ErrorCode::parse, "PARAM without name and value"});
  if (log_.parameters.size() < kMax) log_.parameters[std::string(name)] = std::string(value);
}

void LineCollector::take_other(std::string_view tag) {
  constexpr std::size_t kMax = 64;
  if (!is_word(tag)) {
    return skip(Error{ErrorCode::parse, "unreadable bytes: '" + text::printable(tag) + "'"});
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

void LineCollector::note_invalid_ranges(std::size_t beams) {
  const std::size_t count = parser_.invalid_ranges();
  log_.statistics.invalid_ranges += count;
  note_invalid(count,
               std::to_string(count) + " of " + std::to_string(beams) +
                   " ranges are negative or not finite; treated as no return",
               lines_with_invalid_ranges_);
}

void LineCollector::note_invalid(std::size_t count, const std::string& message,
                                 std::size_t& lines) {
  // Logs that write NaN for every beam without a return must not hide other problems.
  constexpr std::size_t kLinesReported = 20;
  if (count == 0 || ++lines > kLinesReported) return;
  faults_.note(Error{ErrorCode::invalid, message}, line_);
}

}  // namespace wayfare::io::carmen
