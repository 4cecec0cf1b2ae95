#include "slam/robot_calibration/measurements.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include <Eigen/LU>

#include <wayfare/core/random.hpp>

namespace wayfare::calibration {
namespace {

std::string decimal(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

/// The earliest stamp.
LogTime beginning(const Recording& r) {
  std::optional<LogTime> first;
  const auto include = [&](const auto& stream) {
    if (!stream.empty()) first = std::min(first.value_or(stream.front().time), stream.front().time);
  };
  include(r.wheels), include(r.scans), include(r.radar), include(r.gyro);
  return first.value_or(LogTime());
}

std::vector<BaseStep> wheel_steps(const Recording& r, LogTime start) {
  std::vector<BaseStep> steps;
  for (std::size_t i = 1; i < r.wheels.size(); ++i) {
    const WheelSample& w = r.wheels[i];
    const double from = to_seconds(r.wheels[i - 1].time - start), to = to_seconds(w.time - start);
    if (!(to > from) || !std::isfinite(w.left_m) || !std::isfinite(w.right_m)) continue;
    const double rate = 1.0 / (to - from);
    steps.push_back({from, to, {w.left_m * rate, w.right_m * rate, 0.0}});
  }
  return steps;
}

/// Means over intervals of about 0.2 s, of neighbouring frames only.
class RadarMeans {
 public:
  void add(double time_s, const RadarVelocity& v) {
    constexpr double kSpan_s = 0.2, kGap_s = 0.3;
    if (!times_.empty() && time_s - times_.back() > kGap_s) clear();
    times_.push_back(time_s);
    const Eigen::Matrix2d covariance = v.covariance.topLeftCorner<2, 2>();
    const Eigen::Matrix2d information = covariance.inverse();
    information_ += information;
    weighted_ += information * v.velocity_m_s.head<2>();
    const double period = (time_s - times_.front()) / static_cast<double>(times_.size() - 1);
    if (times_.size() < 2 || time_s - times_.front() + period < kSpan_s) return;
    const Eigen::Matrix2d mean = information_.inverse();
    if (mean.allFinite())
      motions_.push_back(
          {times_.front() - 0.5 * period, time_s + 0.5 * period, mean * weighted_, mean});
    clear();
  }
  std::vector<RadarMotion> take() { return std::move(motions_); }

 private:
  void clear() {
    times_.clear();
    information_.setZero(), weighted_.setZero();
  }
  std::vector<double> times_;
  Eigen::Matrix2d information_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d weighted_ = Eigen::Vector2d::Zero();
  std::vector<RadarMotion> motions_;
};

std::vector<GyroTurned> gyro_turns(const Recording& r, LogTime start, double largest_gap_s) {
  constexpr double kSpan_s = 0.2;
  std::vector<GyroTurned> turns;
  GyroTurned now;
  bool open = false;
  for (std::size_t i = 1; i < r.gyro.size(); ++i) {
    const double from = to_seconds(r.gyro[i - 1].time - start);
    const double to = to_seconds(r.gyro[i].time - start), rate = r.gyro[i].turn_rate_rad_s;
    if (!(to > from) || to - from > largest_gap_s || !std::isfinite(rate)) {
      open = false;
      continue;
    }
    if (!std::exchange(open, true)) now = {from, to, 0.0};
    now.to_s = to;
    now.turn_rad += rate * (to - from);
    if (now.to_s - now.from_s < kSpan_s - 1e-6) continue;
    turns.push_back(now);
    open = false;
  }
  return turns;
}

/// The least difference between radial speeds, if there are few of them.
double doppler_step(const std::vector<RadarScan>& scans) {
  constexpr std::size_t kPoints = 5000, kMostBins = 1024;
  constexpr float kSame_m_s = 1e-4F;
  std::vector<float> speeds;
  for (const RadarScan& scan : scans)
    for (const RadarPoint& p : scan.points)
      if (speeds.size() < kPoints && std::isfinite(p.doppler_m_s)) speeds.push_back(p.doppler_m_s);
  std::ranges::sort(speeds);
  float least = 0.0F;
  std::size_t bins = 0;
  for (std::size_t i = 1; i < speeds.size(); ++i) {
    const float gap = speeds[i] - speeds[i - 1];
    if (gap < kSame_m_s) continue;
    ++bins;
    if (least == 0.0F || gap < least) least = gap;
  }
  return bins < kMostBins ? static_cast<double>(least) : 0.0;
}

/// A stream whose longest silence is worth a note.
template <class Stream>
void note_silence(const Stream& stream, const char* name, double usual_s,
                  std::vector<std::string>& notes) {
  Duration longest{0};
  LogTime at;
  for (std::size_t i = 1; i < stream.size(); ++i)
    if (stream[i].time - stream[i - 1].time > longest)
      longest = stream[i].time - stream[i - 1].time, at = stream[i - 1].time;
  if (to_seconds(longest) > usual_s)
    notes.push_back(std::string(name) + " silent for " + decimal(to_seconds(longest)) + " s from " +
                    decimal(at.seconds()) + " s");
}

}  // namespace

Result<Measurements> measure(const Recording& r, const RobotCalibrationOptions& o,
                             const SlamProgress& progress) {
  Measurements m;
  const LogTime start = beginning(r);
  m.wheels = wheel_steps(r, start);
  m.gyro = gyro_turns(r, start, o.largest_gap_s);
  const auto all = static_cast<double>(std::max<std::size_t>(r.scans.size() + r.radar.size(), 1));
  std::size_t done = 0;
  const auto go_on = [&] { return !progress || progress(static_cast<double>(++done) / all); };
  const Error cancelled{ErrorCode::cancelled, "stopped on request"};
  LaserOdometry laser(o);
  ScanDeskewer deskewer(r.T_base_laser);
  for (const LaserScan& scan : r.scans) {
    if (!go_on()) return cancelled;
    const auto instant = deskewer(scan, r.odometry, r.gyro);
    if (instant) laser.add(to_seconds(scan.time - start), end_points(**instant));
  }
  m.laser = laser.take();
  RadarMeans means;
  const Rng rng(1);
  for (const RadarScan& scan : r.radar) {
    if (!go_on()) return cancelled;
    const auto v = radar_velocity(scan, rng.stream(m.radar_frames++), o.velocity);
    if (v) {
      means.add(to_seconds(scan.time - start), *v);
    } else {
      ++m.radar_without;
    }
  }
  m.radar = means.take();
  m.doppler_step_m_s = doppler_step(r.radar);
  note_silence(r.wheels, "wheels", 1.0, m.notes), note_silence(r.scans, "laser", 2.0, m.notes);
  note_silence(r.radar, "radar", 2.0, m.notes), note_silence(r.gyro, "gyro", 1.0, m.notes);
  return m;
}

std::vector<SensorVelocity> velocities_of(const std::vector<LaserMotion>& motions) {
  std::vector<SensorVelocity> all;
  for (const LaserMotion& m : motions) {
    const double dt = m.to_s - m.from_s;
    const Eigen::Vector3d twist = m.T_from_to.log() / dt;
    all.push_back({0.5 * (m.from_s + m.to_s), twist.head<2>(), twist.z()});
  }
  return all;
}

std::vector<SensorVelocity> velocities_of(const std::vector<RadarMotion>& motions) {
  std::vector<SensorVelocity> all;
  for (const RadarMotion& m : motions) all.push_back({0.5 * (m.from_s + m.to_s), m.velocity_m_s});
  return all;
}

}  // namespace wayfare::calibration
