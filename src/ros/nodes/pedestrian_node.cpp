#include <wayfare/ros/nodes.hpp>

#include <array>
#include <cstddef>
#include <utility>

namespace wayfare::ros {

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
