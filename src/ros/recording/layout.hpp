#pragma once

// What a recording says of its frames: where sensors sit on the robot, and where it drove by its
// transforms.

#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/so3.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/frame_tree.hpp>
#include <wayfare/ros/recording.hpp>

#include "ros/recording/lanes.hpp"

namespace wayfare::ros {

struct Layout {
  FrameTree tree;
  std::vector<OdometrySample> by_transforms;  ///< from `odom`, in the order of the messages
  std::string odometry_child;                 ///< of the odometry, else of these transforms

  /// Takes all transforms in as the file is read; what is wrong with one goes to `problems`.
  void listen(Lanes& lanes, const RecordingFile& file, io::Problems& problems);
  /// The robot's frame: as named, else what the odometry moves, else `base_link`.
  [[nodiscard]] std::string base_frame(const TopicNames& names) const;

 private:
  void take(const TfMessage& message, io::Problems& problems);
};

/// A topic's messages are all of one frame, that of the first.
[[nodiscard]] Result<void> take_frame(const Header& header, std::optional<std::string>& frame);

/// How the sensor of `frame` sits on the robot; where nothing says, in its middle, and that is
/// said. Errors: not level.
[[nodiscard]] Result<LevelMounting> mounting_of(const FrameTree& tree, const std::string& base,
                                                const std::string& frame, io::Problems& problems);

/// Rotates the axes of an inertial unit to the robot's; nothing where no transform says.
[[nodiscard]] std::optional<SO3d> rotation_of(const FrameTree& tree, const std::string& base,
                                              const std::string& frame);

}  // namespace wayfare::ros
