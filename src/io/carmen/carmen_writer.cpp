#include <wayfare/io/carmen.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/trajectory.hpp>

#include "io/text/text.hpp"

namespace wayfare::io {
namespace {

/// Appends each number after a blank.
template <class... Numbers>
void append(std::string& out, Numbers... values) {
  ((out += ' ', text::append_number(out, values)), ...);
}

void append(std::string& out, const SE2d& pose) {
  append(out, pose.x(), pose.y(), pose.heading().radians());
}

// The stamp, the host and the logger's clock, for which the stamp is repeated.
void append_end(std::string& out, LogTime time) {
  const std::string stamp = format_nanoseconds(time.nanoseconds());
  out += ' ' + stamp + " wayfare " + stamp + '\n';
}

void append_ranges(std::string& out, const LaserScan& scan) {
  append(out, scan.ranges_m.size());
  // The format has no NaN; the maximum range means "no return".
  for (const float range : scan.ranges_m)
    append(out, std::isfinite(range) && range >= 0.0F ? range : scan.max_range_m);
}

bool near(double a, double b) { return std::abs(a - b) < 1e-9; }

// Whether the bearings of a FLASER line follow from the number of its beams.
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
        odometry_(as_trajectory(recording.odometry)),
        straight_ahead_(near(T_base_laser_.y(), 0.0) &&
                        near(T_base_laser_.heading().radians(), 0.0)) {
    std::stable_sort(odometry_.begin(), odometry_.end(),
                     [](const StampedPose& a, const StampedPose& b) { return a.time < b.time; });
  }

  std::string write() {
    write_head();
    for (const Entry& entry : entries()) write(entry);
    return std::move(out_);
  }

 private:
  void write_head() {
    out_ = "# CARMEN log: metres, radians, seconds, decibels\n";
    // Other mountings follow from the poses in the scan lines.
    if (straight_ahead_) write_parameter("robot_frontlaser_offset", T_base_laser_.x());
    const SE2d& T_base_radar = recording_.T_base_radar.raw();
    write_if_set("robot_radar_offset", T_base_radar.x());
    write_if_set("robot_radar_side_offset", T_base_radar.y());
    write_if_set("robot_radar_angular_offset", T_base_radar.heading().radians());
    write_if_set("robot_radar_max_speed", recording_.radar_max_speed_m_s);
    write_if_set("robot_wheelbase", recording_.wheel_base_m);
    float max_range_m = 0.0F;
    for (const LaserScan& scan : recording_.scans)
      max_range_m = std::max(max_range_m, scan.max_range_m);
    write_if_set("laser_frontlaser_maxrange", max_range_m);
    write_if_set("laser_frontlaser_time_increment", to_seconds(common_time_increment()));
  }

  /// Of all scans, or zero.
  [[nodiscard]] Duration common_time_increment() const {
    const std::vector<LaserScan>& scans = recording_.scans;
    const Duration first = scans.empty() ? Duration::zero() : scans.front().time_increment;
    const bool common = std::all_of(scans.begin(), scans.end(), [&](const LaserScan& scan) {
      return scan.time_increment == first;
    });
    return common ? first : Duration::zero();
  }

  /// In the order of lines of equal time: scans last, after their odometry.
  enum class Kind { odometry, wheels, gyro, truth, radar, scan };
  struct Entry {
    LogTime time;
    Kind kind;
    std::size_t index;
  };

  [[nodiscard]] std::vector<Entry> entries() const {
    std::vector<Entry> all;
    const auto add = [&](const auto& samples, Kind kind) {
      for (std::size_t i = 0; i < samples.size(); ++i) all.push_back({samples[i].time, kind, i});
    };
    add(recording_.odometry, Kind::odometry);
    add(recording_.wheels, Kind::wheels);
    add(recording_.gyro, Kind::gyro);
    add(recording_.truth, Kind::truth);
    add(recording_.radar, Kind::radar);
    add(recording_.scans, Kind::scan);
    std::stable_sort(all.begin(), all.end(), [](const Entry& a, const Entry& b) {
      return std::pair(a.time, a.kind) < std::pair(b.time, b.kind);
    });
    return all;
  }

  void write(const Entry& entry) {
    const std::size_t i = entry.index;
    if (entry.kind == Kind::odometry) return write_odometry(i);
    if (entry.kind == Kind::radar) return write_radar(recording_.radar[i]);
    if (entry.kind == Kind::scan) return write_scan(recording_.scans[i]);
    if (entry.kind == Kind::wheels) {
      const WheelSample& sample = recording_.wheels[i];
      write_line("WHEELS", entry.time, sample.left_m, sample.right_m);
    } else if (entry.kind == Kind::gyro) {
      write_line("GYRO", entry.time, recording_.gyro[i].turn_rate_rad_s);
    } else {
      write_line("TRUEPOS", entry.time, recording_.truth[i].T_map_base.raw(),
                 odometry_at(entry.time));
    }
  }

  template <class... Values>
  void write_line(const char* tag, LogTime time, const Values&... values) {
    out_ += tag;
    (append(out_, values), ...);
    append_end(out_, time);
  }

  void write_radar(const RadarScan& scan) {
    out_ += "RADAR";
    append(out_, scan.points.size());
    for (const RadarPoint& p : scan.points)
      append(out_, p.x_m, p.y_m, p.z_m, p.doppler_m_s, p.snr_db);
    append_end(out_, scan.time);
  }

  template <class Number>
  void write_parameter(const char* name, Number value) {
    out_.append("PARAM ").append(name);
    append(out_, value);
    out_ += '\n';
  }
  template <class Number>
  void write_if_set(const char* name, Number value) {
    if (value != Number(0)) write_parameter(name, value);
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
    write_line("ODOM", sample.time, sample.T_odom_base.raw(), speed, turn_rate, 0.0);
  }

  // Constant before the first sample and after the last.
  [[nodiscard]] SE2d odometry_at(LogTime time) const {
    if (odometry_.empty()) return {};
    return *pose_at(odometry_, std::clamp(time, odometry_.front().time, odometry_.back().time));
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
    append(out_, scan.first_bearing.radians(), step * std::max(0.0, beams - 1.0), step,
           static_cast<double>(scan.max_range_m));
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

}  // namespace wayfare::io
