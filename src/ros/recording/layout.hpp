#pragma once

// Frames of a recording: the sensors' mounting on the robot, and its odometry by transforms.

#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/so3.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/recording.hpp>

#include "ros/recording/lanes.hpp"

namespace wayfare::ros {

struct Layout {
  FrameTree tree;
  std::vector<OdometrySample> by_transforms;  ///< from `odom`, in the order of the messages
  std::string odometry_child;                 ///< child of the odometry, else of these transforms

  /// Adds all transforms while the file is read; errors in one are reported in `problems`.
  void listen(Lanes& lanes, const RecordingFile& file, io::Problems& problems);
  /// The robot's frame: as named, else the odometry's child, else `base_link`.
  [[nodiscard]] std::string base_frame(const TopicNames& names) const;

 private:
  void take(const TfMessage& message, io::Problems& problems);
};

/// All messages of a topic have one frame, that of the first.
[[nodiscard]] Result<void> take_frame(const Header& header, std::optional<std::string>& frame);

/// Mounting of the sensor of `frame` on the robot; without a transform, at its centre, with a note.
/// Errors: not level.
[[nodiscard]] Result<LevelMounting> mounting_of(const FrameTree& tree, const std::string& base,
                                                const std::string& frame, io::Problems& problems);

/// Rotates an inertial unit's axes to the robot's; nothing without a transform.
[[nodiscard]] std::optional<SO3d> rotation_of(const FrameTree& tree, const std::string& base,
                                              const std::string& frame);

}  // namespace wayfare::ros
