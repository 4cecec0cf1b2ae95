#include "ros/recording/layout.hpp"

#include <cmath>

namespace wayfare::ros {

void Layout::listen(Lanes& lanes, const RecordingFile& file, io::Problems& problems) {
  for (const Topic& topic : file.topics())
    if (topic.type == TfMessage::kType.name || topic.type == "tf/tfMessage")
      lanes.visit<TfMessage>(topic.name, [&](const TfMessage& m) { take(m, problems); });
}

void Layout::take(const TfMessage& message, io::Problems& problems) {
  constexpr std::string_view kOdomFrame = "odom";
  for (const TransformStamped& t : message.transforms) {
    tree.add(t);
    if (frame_of(t.header) != kOdomFrame) continue;
    const auto time = time_of(t.header.stamp);
    const auto pose = plane_pose_of(
        {{t.transform.translation.x, t.transform.translation.y, 0.0}, t.transform.rotation});
    if (time && pose) {
      by_transforms.push_back({*time, Transform2<frame::Odom, frame::Base>(*pose)});
      odometry_child = t.child_frame_id;
    } else {
      problems.add({ErrorCode::parse, time ? pose.error().message : time.error().message,
                    "transform " + t.child_frame_id});
    }
  }
}

std::string Layout::base_frame(const TopicNames& names) const {
  if (!names.base_frame.empty()) return names.base_frame;
  return odometry_child.empty() ? "base_link" : odometry_child;
}

Result<void> take_frame(const Header& header, std::optional<std::string>& frame) {
  if (!frame) frame = frame_of(header);
  return check_frame(header, *frame);
}

Result<LevelMounting> mounting_of(const FrameTree& tree, const std::string& base,
                                  const std::string& frame, io::Problems& problems) {
  const auto found = tree.find(base, frame);
  if (found) return level_mounting_of(*found);
  problems.add(
      {ErrorCode::not_found,
       found.error().message + ": the sensor is assumed at the origin of the robot's frame",
       "frame " + frame});
  return LevelMounting{};
}

std::optional<SO3d> rotation_of(const FrameTree& tree, const std::string& base,
                                const std::string& frame) {
  const auto found = tree.find(base, frame);
  if (!found) return std::nullopt;
  const Quaternion& r = found->rotation;
  const Eigen::Quaterniond q(r.w, r.x, r.y, r.z);
  if (!(std::abs(q.squaredNorm() - 1.0) < 1e-2)) return std::nullopt;
  return SO3d(q);
}

}  // namespace wayfare::ros
