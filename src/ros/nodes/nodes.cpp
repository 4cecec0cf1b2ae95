#include <wayfare/ros/nodes.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "ros/nodes/laser_slam.hpp"
#include "ros/nodes/samples.hpp"

namespace wayfare::ros {

SlamNode::SlamNode(SlamNodeOptions options)
    : ScanNode(options), options_(std::move(options)), slam_(nullptr, nullptr) {
  const bool filter = options_.sensors != SlamSensors::lidar;
  if (filter) options_.system = LaserSystem::submap;
  const bool walker = options_.system == LaserSystem::pedestrian;
  options_.odometry = (options_.odometry && !walker) || filter;
  options_.imu = walker || (options_.imu && !(takes_turns() && options_.odometry));
  options_.magnetometer = walker && options_.magnetometer;
}

void SlamNode::add(const LaserScan& message, double now_s) {
  if (options_.sensors == SlamSensors::radar) return;
  const auto time = time_of(message.header.stamp);
  enqueue(lasers_, time ? laser_scan_of(message, *time) : Result<wayfare::LaserScan>(time.error()),
          message.header, now_s, restart());
}

void SlamNode::add(const RadarScan& message, double now_s) {
  add_radar(message, RadarMessage::scan, now_s);
}

void SlamNode::add(const PointCloud2& message, double now_s) {
  add_radar(message, RadarMessage::cloud, now_s);
}

template <class Message>
void SlamNode::add_radar(const Message& message, RadarMessage kind, double now_s) {
  if (options_.sensors == SlamSensors::lidar) return;
  if (radar_message_ == RadarMessage::none) radar_message_ = kind;
  if (radar_message_ != kind) return;
  const auto time = time_of(message.header.stamp);
  enqueue(radar_, time ? radar_scan_of(message, *time) : Result<wayfare::RadarScan>(time.error()),
          message.header, now_s, restart());
}

ScanNode::Restart SlamNode::restart() {
  return {"begins a new map", [this](LogTime at) { restart_at(at); }};
}

void SlamNode::add(const Odometry& message, double now_s) {
  if (!options_.odometry) return;
  auto sample = next_odometry(message, now_s);
  if (!sample) return;
  if (odometry_.empty()) T_joined_odom_.reset();
  const SE2d T_odom_base = sample->T_odom_base.raw();
  if (!odometry_.empty()) {
    constexpr double kSlack_m = 0.5;
    const OdometrySample& last = odometry_.back();
    const SE2d before = last.T_odom_base.raw();
    const SE2d joined = T_joined_odom_ ? *T_joined_odom_ * T_odom_base : T_odom_base;
    const double moved_m = (before.inverse() * joined).translation().norm();
    if (moved_m > kSlack_m + options_.max_speed_mps * to_seconds(sample->time - last.time)) {
      notices_.add(Severity::warning, "leap",
                   "odometry jumped by " + std::to_string(moved_m) +
                       " m: it was set, or the robot was carried",
                   now_s);
      // Where scans of a laser tell which, they begin a piece; a radar alone cannot.
      if (options_.sensors != SlamSensors::both) T_joined_odom_ = before * T_odom_base.inverse();
      leaps_.push_back({last.time, sample->time});
    }
  }
  if (T_joined_odom_)
    sample->T_odom_base = Transform2<frame::Odom, frame::Base>(*T_joined_odom_ * T_odom_base);
  add_odometry(*sample);
}

void SlamNode::add(const Imu& message, double now_s) {
  if (!options_.imu) return;
  const auto time = time_of(message.header.stamp);
  const auto done = !time           ? Result<void>(time.error())
                    : takes_turns() ? add_turn_rate(message, *time)
                                    : add_sample(message, *time);
  if (!done)
    leave_out("inertial sample", "bad reading",
              "left out an inertial sample: " + done.error().to_string(), now_s);
}

/// Whether a unit's sample is later than those before; a step back drops those.
bool SlamNode::is_next(LogTime time) {
  auto& last = unit_heard_.last;
  if (last && time + from_seconds(options_.jump_back_s) < *last)
    gyro_.clear(), unit_.clear(), last.reset();
  if (last && time <= *last) return false;
  unit_heard_.hear(time);
  return true;
}

Result<void> SlamNode::add_turn_rate(const Imu& message, LogTime time) {
  const auto rate = turn_rate_of(message);
  if (!rate) return rate.error();
  if (is_next(time)) gyro_.push_back({time, rate->z()});
  return {};
}

Result<void> SlamNode::add_sample(const Imu& message, LogTime time) {
  const auto sample = imu_of(message, time);
  if (!sample) return sample.error();
  if (unit_frame_.empty()) unit_frame_ = frame_of(message.header);
  if (auto ok = check_frame(message.header, unit_frame_); !ok) return ok;
  if (!is_next(time)) return {};
  MargSample& to = sample_at(time);
  to.angular_rate_radps = sample->angular_rate_radps;
  to.specific_force_mps2 = sample->specific_force_mps2;
  return {};
}

void SlamNode::add(const MagneticField& message, double now_s) {
  if (!options_.magnetometer) return;
  const auto time = time_of(message.header.stamp);
  if (!time)
    return leave_out("magnetic field", "bad field",
                     "left out a magnetometer's sample: " + time.error().to_string(), now_s);
  if (last_scan_ && *time <= *last_scan_) return;
  sample_at(*time).magnetic_field_uT = field_uT_of(message);
  field_heard_.hear(*time);
}

/// Rate, force and field of one time are one sample.
MargSample& SlamNode::sample_at(LogTime time) {
  constexpr std::size_t kMost = 20'000;  // minutes without a scan
  if (unit_.size() >= kMost) pass_samples(unit_.front().time);
  const auto at = std::lower_bound(unit_.begin(), unit_.end(), time,
                                   [](const MargSample& s, LogTime t) { return s.time < t; });
  if (at != unit_.end() && at->time == time) return *at;
  return *unit_.insert(at, MargSample{time});
}

void SlamNode::add(const TfMessage& message) {
  for (const TransformStamped& t : message.transforms) frames_.add(t);
}

void SlamNode::restart_at(LogTime at) {
  slam_.reset();
  stream_.reset();
  odometry_passed_.reset();
  lasers_.scans.clear();
  radar_.scans.clear();
  lasers_.last_received.reset();
  radar_.last_received.reset();
  last_scan_.reset();
  last_cloud_.reset();
  leaps_.clear();
  said_ = {};
  settled_ = true;
  // Data of the other topics up to the jump back is dropped, too.
  const LogTime until = at + from_seconds(options_.jump_back_s);
  forget_odometry_after(until);
  forget_after(gyro_, until);
  forget_after(unit_, until);
  unit_heard_.last = takes_turns() ? last_of(gyro_) : last_of(unit_);
  field_heard_.last.reset();
  if (odometry_.empty()) T_joined_odom_.reset();
}

PedestrianNode::PedestrianNode(PedestrianNodeOptions options)
    : options_(std::move(options)), pedestrian_(options_.pedestrian) {}

PedestrianNodeOutput PedestrianNode::add(const Imu& message, double now_s) {
  PedestrianNodeOutput out;
  const auto time = time_of(message.header.stamp);
  const auto sample = time ? imu_of(message, *time) : Result<ImuSample>(time.error());
  if (sample) {
    take({sample->time, sample->angular_rate_radps, sample->specific_force_mps2}, now_s, out);
  } else {
    notices_.add(Severity::error, "bad reading",
                 "left out an inertial sample: " + sample.error().to_string(), now_s);
  }
  out.notices = notices_.take();
  return out;
}

PedestrianNodeOutput PedestrianNode::add(const MagneticField& message, double now_s) {
  PedestrianNodeOutput out;
  const auto time = time_of(message.header.stamp);
  if (time) {
    MargSample sample{*time};
    sample.magnetic_field_uT = field_uT_of(message);
    take(sample, now_s, out);
  } else {
    notices_.add(Severity::error, "bad field",
                 "left out a magnetometer's sample: " + time.error().to_string(), now_s);
  }
  out.notices = notices_.take();
  return out;
}

PedestrianNodeOutput PedestrianNode::idle(double now_s) {
  constexpr double kPatience_s = 2.0;
  if (!heard_s_) heard_s_ = now_s;
  if (now_s >= *heard_s_ + kPatience_s)
    notices_.add(Severity::info, "waits", "waits for inertial samples", now_s);
  return {{}, notices_.take()};
}

void PedestrianNode::take(const MargSample& sample, double now_s, PedestrianNodeOutput& out) {
  heard_s_ = now_s;
  if (last_ && sample.time + from_seconds(options_.jump_back_s) < *last_) {
    notices_.add(Severity::warning, "back",
                 "time went back by " + std::to_string(to_seconds(*last_ - sample.time)) +
                     " s: restarts at the origin",
                 now_s);
    pedestrian_ = Pedestrian(options_.pedestrian);
    before_.reset();
    last_pose_.reset();
  }
  last_ = sample.time;
  pedestrian_.add(sample, [&](const PedestrianPose& pose) {
    // A late step is in the next pose.
    if (last_pose_ && pose.time <= *last_pose_) return;
    out.odometry.push_back(
        odometry_message(pose, before_, options_.odom_frame, options_.base_frame));
    before_ = pose;
    last_pose_ = pose.time;
  });
  rest(out);
}

/// Odometry without motion up to the time until which there is no step.
void PedestrianNode::rest(PedestrianNodeOutput& out) {
  const auto settled = pedestrian_.settled();
  if (!settled) return;
  const LogTime known = *settled - from_seconds(options_.rest_margin_s);
  if (last_pose_ && known < *last_pose_ + from_seconds(options_.rest_period_s)) return;
  const auto pose = pedestrian_.pose_at_rest(known);
  if (!pose || known.nanoseconds() <= 0) return;
  out.odometry.push_back(
      odometry_message(*pose, std::nullopt, options_.odom_frame, options_.base_frame));
  last_pose_ = known;
}

Odometry odometry_message(const PedestrianPose& pose, const std::optional<PedestrianPose>& before,
                          const std::string& odom_frame, const std::string& base_frame) {
  Odometry message = message_of(pose.odometry(), odom_frame, base_frame);
  // Of x, y, z and rotations about them: quantities not estimated are unknown.
  constexpr double kUnknown = 1e6;
  constexpr std::array<std::size_t, 3> kInPlane = {0, 1, 5};
  for (std::size_t i = 0; i < 6; ++i) message.pose.covariance[7 * i] = kUnknown;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      message.pose.covariance[6 * kInPlane[i] + kInPlane[j]] =
          pose.covariance(static_cast<int>(i), static_cast<int>(j));
  if (before && pose.time > before->time)
    message.twist.twist.linear.x = pose.length_m / to_seconds(pose.time - before->time);
  return message;
}

}  // namespace wayfare::ros
