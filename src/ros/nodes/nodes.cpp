#include <wayfare/ros/nodes.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace wayfare::ros {
namespace {

std::string seconds(Duration d) { return std::to_string(to_seconds(d)) + " s"; }

template <class Sample>
void forget_after(std::vector<Sample>& samples, LogTime time) {
  std::erase_if(samples, [&](const Sample& s) { return s.time > time; });
}

}  // namespace

SlamNode::SlamNode(SlamNodeOptions options)
    : options_(std::move(options)), slam_(std::make_unique<SubmapSlam>(options_.slam)) {
  options_.odometry = options_.odometry || options_.sensors != SlamSensors::lidar;
}

void SlamNode::add(const LaserScan& message, double now_s) {
  if (options_.sensors == SlamSensors::radar) return;
  const auto time = time_of(message.header.stamp);
  enqueue(lasers_, time ? laser_scan_of(message, *time) : Result<wayfare::LaserScan>(time.error()),
          message.header, now_s);
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
          message.header, now_s);
}

template <class Scan>
void SlamNode::enqueue(Sensed<Scan>& to, Result<Scan> scan, const Header& header, double now_s) {
  if (!scan)
    return notices_.add(Severity::error, "bad scan", "left out a scan: " + scan.error().to_string(),
                        now_s);
  const std::string frame(frame_of(header));
  if (to.frame.empty()) to.frame = frame;
  if (frame != to.frame)
    return notices_.add(
        Severity::error, "other than " + to.frame,
        "left out scans in frame '" + frame + "': the map uses those in '" + to.frame + "'", now_s);
  if (to.last_received && scan->time + from_seconds(options_.jump_back_s) < *to.last_received) {
    notices_.add(
        Severity::warning, "back",
        "time went back by " + seconds(*to.last_received - scan->time) + ": begins a new map",
        now_s);
    begin_anew(scan->time);
  } else if (to.last_received && scan->time <= *to.last_received) {
    return notices_.add(Severity::warning, "late scan",
                        "left out a scan that is " + seconds(*to.last_received - scan->time) +
                            " earlier than the one before it",
                        now_s);
  }
  to.last_received = scan->time;
  to.scans.push_back(*std::move(scan));
  if (to.scans.size() <= options_.scans_waiting) return;
  to.scans.pop_front();
  notices_.add(Severity::warning, "too many",
               "scans arrive faster than they are processed, or while it waits: the oldest are "
               "left out",
               now_s);
}

void SlamNode::add(const Odometry& message, double now_s) {
  if (!options_.odometry) return;
  const auto time = time_of(message.header.stamp);
  auto ok = check_frame(message.header, options_.odom_frame);
  if (ok && !time) ok = time.error();
  auto sample = ok ? odometry_of(message, *time) : Result<OdometrySample>(ok.error());
  if (!sample)
    return notices_.add(Severity::error, "bad odometry",
                        "left out odometry: " + sample.error().to_string(), now_s);
  const SE2d T_odom_base = sample->T_odom_base.raw();
  if (!odometry_.empty()) {
    const OdometrySample& last = odometry_.back();
    if (*time + from_seconds(options_.jump_back_s) < last.time) {
      odometry_.clear();
      T_joined_odom_.reset();
    } else if (*time <= last.time) {
      return;
    } else {
      constexpr double kSlack_m = 0.5;
      const SE2d before = last.T_odom_base.raw();
      const SE2d joined = T_joined_odom_ ? *T_joined_odom_ * T_odom_base : T_odom_base;
      const double moved_m = (before.inverse() * joined).translation().norm();
      if (moved_m > kSlack_m + options_.max_speed_mps * to_seconds(*time - last.time)) {
        notices_.add(Severity::warning, "leap",
                     "odometry jumped by " + std::to_string(moved_m) +
                         " m: taken as a reset, with the robot at rest",
                     now_s);
        T_joined_odom_ = before * T_odom_base.inverse();
      }
    }
  }
  if (T_joined_odom_)
    sample->T_odom_base = Transform2<frame::Odom, frame::Base>(*T_joined_odom_ * T_odom_base);
  odometry_.push_back(*sample);
  motion_missing_ = false;
}

void SlamNode::add(const Imu& message, double now_s) {
  if (options_.odometry || !options_.imu) return;
  const auto time = time_of(message.header.stamp);
  const auto rate = time ? turn_rate_of(message) : Result<Eigen::Vector3d>(time.error());
  if (!rate)
    return notices_.add(Severity::error, "bad reading",
                        "left out an inertial sample: " + rate.error().to_string(), now_s);
  if (!gyro_.empty() && *time + from_seconds(options_.jump_back_s) < gyro_.back().time)
    gyro_.clear();
  if (!gyro_.empty() && *time <= gyro_.back().time) return;
  gyro_.push_back({*time, rate->z()});
  motion_missing_ = false;
}

void SlamNode::add(const TfMessage& message) {
  for (const TransformStamped& t : message.transforms) frames_.add(t);
}

void SlamNode::begin_anew(LogTime at) {
  slam_ = std::make_unique<SubmapSlam>(options_.slam);
  stream_.reset();
  odometry_passed_.reset();
  lasers_.scans.clear();
  radar_.scans.clear();
  lasers_.last_received.reset();
  radar_.last_received.reset();
  last_scan_.reset();
  settled_ = true;
  // Data of the other topics up to the jump back is dropped, too.
  const LogTime until = at + from_seconds(options_.jump_back_s);
  forget_after(odometry_, until);
  forget_after(gyro_, until);
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
  }
  last_ = sample.time;
  pedestrian_.add(sample, [&](const PedestrianPose& pose) {
    out.odometry.push_back(
        odometry_message(pose, before_, options_.odom_frame, options_.base_frame));
    before_ = pose;
  });
}

Odometry odometry_message(const PedestrianPose& pose, const std::optional<PedestrianPose>& before,
                          const std::string& odom_frame, const std::string& base_frame) {
  Odometry message = message_of(pose.odometry(), odom_frame, base_frame);
  // Of x, y, z and rotations about them: quantities not estimated are unknown.
  constexpr double kUnknown = 1e6;
  constexpr std::array<std::size_t, 3> kPlane = {0, 1, 5};
  for (std::size_t i = 0; i < 6; ++i) message.pose.covariance[7 * i] = kUnknown;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      message.pose.covariance[6 * kPlane[i] + kPlane[j]] =
          pose.covariance(static_cast<int>(i), static_cast<int>(j));
  if (before && pose.time > before->time)
    message.twist.twist.linear.x = pose.length_m / to_seconds(pose.time - before->time);
  return message;
}

}  // namespace wayfare::ros
