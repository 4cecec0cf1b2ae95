#include <algorithm>
#include <cmath>

#include <wayfare/nav/corridor_ins.hpp>

namespace wayfare {
namespace {

bool is_finite(const OdometrySample& o) {
  const SE2d& pose = o.T_odom_base.raw();
  return std::isfinite(pose.x() + pose.y() + pose.heading().radians());
}

/// Odometry motion between two samples.
Eigen::Vector3d step_between(const OdometrySample& before, const OdometrySample& after) {
  return (before.T_odom_base.raw().inverse() * after.T_odom_base.raw()).log();
}

/// Distance travelled by a time from the wheels, else from odometry; interpolated linearly.
class DistanceTravelled {
 public:
  explicit DistanceTravelled(const Recording& r) {
    for (const WheelSample& w : r.wheels)
      if (std::isfinite(w.left_m + w.right_m)) append(w.time, 0.5 * (w.left_m + w.right_m));
    if (!times_.empty()) return;
    const OdometrySample* before = nullptr;
    for (const OdometrySample& o : r.odometry) {
      if (!is_finite(o)) continue;
      append(o.time, before != nullptr ? step_between(*before, o).x() : 0.0);
      before = &o;
    }
  }
  [[nodiscard]] bool empty() const { return times_.empty(); }
  [[nodiscard]] double at(LogTime time) const {
    const auto next = std::upper_bound(times_.begin(), times_.end(), time);
    const auto i = static_cast<std::size_t>(next - times_.begin());
    if (i == 0) return distance_m_.front();
    if (i == times_.size()) return distance_m_.back();
    const double u = to_seconds(time - times_[i - 1]) / to_seconds(times_[i] - times_[i - 1]);
    return distance_m_[i - 1] + u * (distance_m_[i] - distance_m_[i - 1]);
  }

 private:
  void append(LogTime time, double by_m) {
    distance_m_.push_back(by_m + (distance_m_.empty() ? 0.0 : distance_m_.back()));
    times_.push_back(time);
  }

  std::vector<LogTime> times_;
  std::vector<double> distance_m_;
};

std::vector<MotionSample> from_gyro(const Recording& r, const DistanceTravelled& travelled) {
  std::vector<MotionSample> motion;
  for (std::size_t i = 0; i < r.gyro.size(); ++i) {
    const LogTime time = r.gyro[i].time;
    const double dt = i > 0 ? to_seconds(time - r.gyro[i - 1].time) : 0.0;
    if (i > 0 && !(dt > 0.0)) continue;
    const double distance = i > 0 ? travelled.at(time) - travelled.at(r.gyro[i - 1].time) : 0.0;
    motion.push_back({time, r.gyro[i].turn_rate_rad_s, i > 0 ? distance / dt : 0.0});
  }
  return motion;
}

std::vector<MotionSample> from_odometry(const Recording& r) {
  std::vector<MotionSample> motion;
  const OdometrySample* before = nullptr;
  for (const OdometrySample& o : r.odometry) {
    if (!is_finite(o)) continue;
    if (before != nullptr && o.time <= before->time) continue;
    MotionSample sample{o.time};
    if (before != nullptr) {
      const double dt = to_seconds(o.time - before->time);
      const Eigen::Vector3d twist = step_between(*before, o);
      sample.speed_m_s = twist.x() / dt;
      sample.turn_rate_rad_s = twist.z() / dt;
    }
    motion.push_back(sample);
    before = &o;
  }
  return motion;
}

}  // namespace

std::vector<MotionSample> motion_of(const Recording& recording, double added_bias_rad_s) {
  const DistanceTravelled travelled(recording);
  const bool has_gyro = !recording.gyro.empty() && !travelled.empty();
  auto motion = has_gyro ? from_gyro(recording, travelled) : from_odometry(recording);
  for (MotionSample& sample : motion) sample.turn_rate_rad_s += added_bias_rad_s;
  return motion;
}

Result<CorridorRun> run_corridor_ins(const Recording& recording,
                                     std::span<const MotionSample> motion,
                                     const CorridorInsOptions& options, const SE2d& start,
                                     const std::function<void(double)>& progress) {
  if (recording.scans.empty())
    return Error{ErrorCode::invalid, "the recording has no laser scan", {}};
  if (motion.empty())
    return Error{ErrorCode::invalid, "the recording has neither gyro and wheels nor odometry", {}};
  CorridorIns ins(options, start);
  CorridorRun run;
  std::size_t next = 0, done = 0;
  for (const LaserScan& scan : recording.scans) {
    // Rejected samples are counted in the report.
    for (; next < motion.size() && motion[next].time <= scan.time; ++next)
      static_cast<void>(ins.add_motion(motion[next]).has_value());
    auto update = ins.add_scan(scan);
    if (progress)
      progress(static_cast<double>(++done) / static_cast<double>(recording.scans.size()));
    if (!update) {
      if (run.refused_scans++ == 0) run.first_refusal = update.error().to_string();
      continue;
    }
    run.epochs.push_back({scan.time, ins.pose(), ins.pose_covariance(), ins.gyro_bias(),
                          ins.speed_scale(), ins.joint_covariance(), *std::move(update)});
  }
  run.report = ins.report();
  return run;
}

}  // namespace wayfare
