// Stamps, frames and poses in the plane.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include <wayfare/core/se3.hpp>
#include <wayfare/ros/convert.hpp>

#include "ros/transform_parts.hpp"

namespace wayfare::ros {
namespace {

constexpr std::uint32_t kSecond = 1'000'000'000;

/// The rotation of (0, 0, z, w), computed from its angle: this preserves the last bits of a heading
/// read from text.
SO2d half_angle(double z, double w) { return SO2d(Angle::radians(2.0 * std::atan2(z, w))); }

bool same_bits(const SO2d& a, const SO2d& b) { return a.cos() == b.cos() && a.sin() == b.sin(); }

double next(double value, int steps) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  for (; steps > 0; --steps) value = std::nextafter(value, kFar);
  for (; steps < 0; ++steps) value = std::nextafter(value, -kFar);
  return value;
}

TransformParts parts(const SE3d& t) {
  const auto& q = t.rotation().quaternion();
  return {{t.translation().x(), t.translation().y(), t.translation().z()},
          {q.x(), q.y(), q.z(), q.w()}};
}

bool is_finite(const Point& p) { return std::isfinite(p.x) && std::isfinite(p.y); }

}  // namespace

Result<LogTime> time_of(const Stamp& stamp) {
  const auto wrong = [](const char* what) { return Error{ErrorCode::invalid, what, "stamp"}; };
  if (stamp == Stamp{}) return wrong("is zero: the sender set no time");
  if (stamp.sec < 0) return wrong("is before 1970");
  if (stamp.sec > std::numeric_limits<std::uint32_t>::max()) return wrong("is after 2106");
  if (stamp.nanosec >= kSecond) return wrong("has a second or more of nanoseconds");
  return LogTime::from_nanoseconds(stamp.sec * std::int64_t{kSecond} + stamp.nanosec);
}

Stamp stamp_of(LogTime time) {
  WAYFARE_EXPECTS(time >= LogTime(), "ROS has no time before 1970");
  return {time.nanoseconds() / kSecond, static_cast<std::uint32_t>(time.nanoseconds() % kSecond)};
}

Header header_of(LogTime time, std::string_view frame) {
  return {0, stamp_of(time), std::string(frame)};
}

std::string_view frame_of(const Header& header) { return without_slash(header.frame_id); }

Result<void> check_frame(const Header& header, std::string_view wanted) {
  const std::string_view frame = frame_of(header);
  if (frame == wanted) return {};
  return Error{ErrorCode::invalid,
               (frame.empty() ? "names no frame" : "is of frame '" + std::string(frame) + "'") +
                   ", not of '" + std::string(wanted) + "'",
               "frame_id"};
}

Result<void> check_clock(LogTime time, LogTime now, Duration tolerance) {
  const Duration off = time - now;
  if (off <= tolerance && off >= -tolerance) return {};
  const std::string seconds = std::to_string(std::abs(to_seconds(off)));
  return Error{ErrorCode::invalid,
               "is " + seconds + " s " + (off > Duration(0) ? "ahead of" : "behind") +
                   " the receiver's clock: another clock, or a recording played without its own",
               "stamp"};
}

Quaternion quaternion_of(const SO2d& rotation) {
  const double half = 0.5 * rotation.angle().radians();
  const Quaternion first{0.0, 0.0, std::sin(half), std::cos(half)};
  constexpr int kReach = 6;  // steps of the last bit, the nearest first
  for (int reach = 0; reach <= kReach; ++reach)
    for (int dz = -reach; dz <= reach; ++dz)
      for (int dw = -reach; dw <= reach; ++dw) {
        if (std::max(std::abs(dz), std::abs(dw)) != reach) continue;
        const double z = next(first.z, dz), w = next(first.w, dw);
        if (same_bits(half_angle(z, w), rotation)) return {0.0, 0.0, z, w};
      }
  return first;
}

Result<SO2d> yaw_of(const Quaternion& q) {
  if (!is_unit(q))
    return Error{ErrorCode::invalid, "is no unit quaternion: was it set?", "orientation"};
  if (q.x == 0.0 && q.y == 0.0) return half_angle(q.z, q.w);
  return SO2d(Angle::radians(
      std::atan2(2.0 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z)));
}

Pose pose_of(const SE2d& pose) {
  return {{pose.x(), pose.y(), 0.0}, quaternion_of(pose.rotation())};
}

Result<SE2d> plane_pose_of(const Pose& pose) {
  if (!is_finite(pose.position)) return Error{ErrorCode::invalid, "is not finite", "position"};
  const auto yaw = yaw_of(pose.orientation);
  if (!yaw) return yaw.error();
  return SE2d(Eigen::Vector2d(pose.position.x, pose.position.y), *yaw);
}

TransformStamped transform_of(const SE2d& T_parent_child, LogTime time, std::string_view parent,
                              std::string_view child) {
  return {
      header_of(time, parent),
      std::string(child),
      {{T_parent_child.x(), T_parent_child.y(), 0.0}, quaternion_of(T_parent_child.rotation())}};
}

Result<LevelMounting> level_mounting_of(const TransformParts& T_base_sensor, double max_tilt_rad) {
  const Quaternion& q = T_base_sensor.rotation;
  const auto yaw = yaw_of(q);
  if (!yaw) return yaw.error();
  // Direction of the laser's z axis: up, down, or sideways.
  const double up = q.w * q.w - q.x * q.x - q.y * q.y + q.z * q.z;
  if (!(std::abs(up) >= std::cos(max_tilt_rad)))
    return Error{ErrorCode::unsupported,
                 "tilts the sensor by " +
                     std::to_string(std::acos(std::abs(up)) * 180.0 / std::numbers::pi) +
                     " degrees: its scan plane is not level",
                 "rotation"};
  const Eigen::Vector2d at(T_base_sensor.translation.x, T_base_sensor.translation.y);
  if (!at.allFinite()) return Error{ErrorCode::invalid, "is not finite", "translation"};
  return LevelMounting{Transform2<frame::Base, Sensor>(SE2d(at, *yaw)), up < 0.0};
}

wayfare::LaserScan turned_over(wayfare::LaserScan scan) {
  const auto last = static_cast<double>(scan.ranges_m.empty() ? 0 : scan.ranges_m.size() - 1);
  scan.first_bearing = -(scan.first_bearing + scan.bearing_step * last);
  scan.ranges_m = {scan.ranges_m.rbegin(), scan.ranges_m.rend()};
  scan.time_increment = -scan.time_increment;
  scan.bearings = {scan.bearings.rbegin(), scan.bearings.rend()};
  for (Angle& bearing : scan.bearings) bearing = -bearing;
  return scan;
}

Result<OdometrySample> odometry_of(const Odometry& message, LogTime time) {
  const auto pose = plane_pose_of(message.pose.pose);
  if (!pose) return pose.error();
  return OdometrySample{time, Transform2<frame::Odom, frame::Base>(*pose)};
}

Odometry message_of(const OdometrySample& sample, std::string_view odom_frame,
                    std::string_view base_frame) {
  Odometry message;
  message.header = header_of(sample.time, odom_frame);
  message.child_frame_id = base_frame;
  message.pose.pose = pose_of(sample.T_odom_base.raw());
  return message;
}

PoseStamped message_of(const StampedPose& pose, std::string_view frame) {
  return {header_of(pose.time, frame), pose_of(pose.T_map_base.raw())};
}

void FrameTree::add(const TransformStamped& t) {
  parents_[std::string(without_slash(t.child_frame_id))] = {std::string(frame_of(t.header)),
                                                            t.transform};
}

Result<TransformParts> FrameTree::find(std::string_view base, std::string_view frame) const {
  base = without_slash(base), frame = without_slash(frame);
  if (base == frame) return TransformParts{{}, {0.0, 0.0, 0.0, 1.0}};
  const auto direct = parents_.find(frame);
  if (direct != parents_.end() && direct->second.name == base) return direct->second.transform;
  // Up from both, to the first common frame. No path is longer than the number of frames.
  struct Step {
    std::string_view name;
    SE3d pose;  ///< of the start of the path, in `name`
  };
  const auto way_up = [&](std::string_view from) {
    std::vector<Step> path{{from, SE3d()}};
    while (path.size() <= parents_.size()) {
      const auto up = parents_.find(path.back().name);
      const auto T = up == parents_.end() ? std::nullopt : rigid(up->second.transform);
      if (!T) break;
      path.push_back({up->second.name, *T * path.back().pose});
    }
    return path;
  };
  const auto up_frame = way_up(frame), up_base = way_up(base);
  for (const Step& a : up_frame)
    for (const Step& b : up_base)
      if (a.name == b.name) return parts(b.pose.inverse() * a.pose);
  std::string there;
  for (const auto& [child, parent] : parents_)
    there += (there.empty() ? "" : ", ") + parent.name + " -> " + child;
  return Error{ErrorCode::not_found, "no transform leads from '" + std::string(base) + "' to '" +
                                         std::string(frame) + "'" +
                                         (there.empty() ? "" : "; there are " + there)};
}

std::optional<SO3d> rotation_of(const FrameTree& tree, std::string_view base,
                                std::string_view frame) {
  const auto found = tree.find(base, frame);
  if (!found) return std::nullopt;
  const Quaternion& r = found->rotation;
  const Eigen::Quaterniond q(r.w, r.x, r.y, r.z);
  if (!(std::abs(q.squaredNorm() - 1.0) < 1e-2)) return std::nullopt;
  return SO3d(q);
}

}  // namespace wayfare::ros
