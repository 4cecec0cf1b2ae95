#include <wayfare/io/carmen_writer.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <wayfare/eval/interpolation.hpp>
#include <wayfare/io/time_text.hpp>

#include "text.hpp"

namespace wayfare::io {
namespace {

void append(std::string& out, double value) {
  out += ' ';
  text::append_number(out, value);
}

void append(std::string& out, const SE2d& pose) {
  append(out, pose.x());
  append(out, pose.y());
  append(out, pose.heading().radians());
}

// The stamp, the host and the logger's own clock, for which the recording's is as good as any.
void append_end(std::string& out, LogTime time) {
  const std::string stamp = format_nanoseconds(time.nanoseconds());
  out += ' ' + stamp + " wayfare " + stamp + '\n';
}

void append_ranges(std::string& out, const LaserScan& scan) {
  out += ' ';
  text::append_number(out, scan.ranges_m.size());
  for (const float range : scan.ranges_m) {
    out += ' ';
    // What is not a number has no place in the format; the largest range means "no return".
    text::append_number(out, std::isfinite(range) && range >= 0.0F ? range : scan.max_range_m);
  }
}

bool near(double a, double b) { return std::abs(a - b) < 1e-9; }

// Whether a reader knows the bearings of a FLASER line from the number of its beams.
bool has_usual_bearings(const LaserScan& scan) {
  const std::size_t n = scan.ranges_m.size();
  const double step_deg = n == 180 || n == 181 ? 1.0 : n == 360 || n == 361 ? 0.5 : 0.0;
  return step_deg > 0.0 && near(scan.first_bearing.degrees(), -90.0) &&
         near(scan.bearing_step.degrees(), step_deg);
}

class Writer {
 public:
  explicit Writer(const Recording& recording)
      : recording_(recording),
        T_base_laser_(recording.T_base_laser.raw()),
        odometry_(eval::as_trajectory(recording.odometry)),
        straight_ahead_(near(T_base_laser_.y(), 0.0) &&
                        near(T_base_laser_.heading().radians(), 0.0)) {}

  std::string write() {
    write_head();
    std::size_t next = 0;
    for (const LaserScan& scan : recording_.scans) {
      for (; next < recording_.odometry.size() && recording_.odometry[next].time <= scan.time;
           ++next)
        write_odometry(next);
      write_scan(scan);
    }
    for (; next < recording_.odometry.size(); ++next) write_odometry(next);
    return std::move(out_);
  }

 private:
  void write_head() {
    out_ = "# CARMEN log: ranges and poses in metres and radians, times in seconds\n";
    if (straight_ahead_) {  // any other mounting follows from the poses in the scans' lines
      out_ += "PARAM robot_frontlaser_offset";
      append(out_, T_base_laser_.x());
      out_ += '\n';
    }
    float max_range_m = 0.0F;
    for (const LaserScan& scan : recording_.scans)
      max_range_m = std::max(max_range_m, scan.max_range_m);
    if (max_range_m <= 0.0F) return;
    out_ += "PARAM laser_frontlaser_maxrange ";
    text::append_number(out_, max_range_m);
    out_ += '\n';
  }

  void write_odometry(std::size_t i) {
    const OdometrySample& sample = recording_.odometry[i];
    double speed = 0.0, turn_rate = 0.0;
    if (i > 0 && sample.time > recording_.odometry[i - 1].time) {
      const OdometrySample& before = recording_.odometry[i - 1];
      const double dt = to_seconds(sample.time - before.time);
      const Eigen::Vector3d twist = sample.T_odom_base.raw().minus(before.T_odom_base.raw()) / dt;
      speed = twist.x();
      turn_rate = twist.z();
    }
    out_ += "ODOM";
    append(out_, sample.T_odom_base.raw());
    append(out_, speed);
    append(out_, turn_rate);
    append(out_, 0.0);
    append_end(out_, sample.time);
  }

  // Held before the first sample and after the last.
  [[nodiscard]] SE2d odometry_at(LogTime time) const {
    if (odometry_.empty()) return {};
    return *eval::pose_at(odometry_,
                          std::clamp(time, odometry_.front().time, odometry_.back().time));
  }

  void write_scan(const LaserScan& scan) {
    const SE2d robot = odometry_at(scan.time);
    const SE2d laser = robot * T_base_laser_;
    if (straight_ahead_ && has_usual_bearings(scan)) {
      out_ += "FLASER";
      append_ranges(out_, scan);
      append(out_, laser);
      append(out_, robot);
    } else {
      write_properties(scan);
      append_ranges(out_, scan);
      out_ += " 0";  // remissions
      append(out_, laser);
      append(out_, robot);
      out_ += " 0 0 0 0 0";  // speed, turn rate, safety distances, turn axis
    }
    append_end(out_, scan.time);
  }

  void write_properties(const LaserScan& scan) {
    const double step = scan.bearing_step.radians();
    const auto beams = static_cast<double>(scan.ranges_m.size());
    out_ += "ROBOTLASER1 0";
    append(out_, scan.first_bearing.radians());
    append(out_, step * std::max(0.0, beams - 1.0));
    append(out_, step);
    append(out_, static_cast<double>(scan.max_range_m));
    out_ += " 0.01 0";  // accuracy, remission mode
  }

  const Recording& recording_;
  SE2d T_base_laser_;
  Trajectory odometry_;
  bool straight_ahead_;
  std::string out_;
};

}  // namespace

std::string format_carmen(const Recording& recording) { return Writer(recording).write(); }

Result<void> write_carmen(const std::string& path, const Recording& recording,
                          const WriteOptions& options) {
  return write_file(path, format_carmen(recording), options);
}

}  // namespace wayfare::io
