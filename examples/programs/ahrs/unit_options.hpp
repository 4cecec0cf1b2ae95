#pragma once

// How the SLAM programs are told about an inertial unit beside the range finder.

#include <optional>
#include <string>

#include <wayfare/core/so3.hpp>
#include <wayfare/sensors/recording.hpp>

#include "recording.hpp"

namespace wayfare::examples {

struct UnitReadings {
  io::MargFile file;
  std::optional<SO3d> q_base_unit = {};  ///< as transforms of a ROS recording say
};

struct UnitOptions {
  std::string path;  ///< empty: the log's own unit, or none
  bool none = false;
  std::string forward = "x";
  RecordingOptions recording;

  void describe(CommandLine& app);
  /// The readings of --unit, or else those in the log where it is a recording that has a unit;
  /// stamped as the log is. Nothing: there is no unit, or `none` is wanted; one in the log that was
  /// not named and cannot be used is said on standard error.
  [[nodiscard]] Result<std::optional<UnitReadings>> read(const std::string& log,
                                                         const ros::TopicNames& topics) const;
  /// The unit's axis along which the laser's x points; z of both points up.
  [[nodiscard]] Eigen::Vector3d forward_axis() const;
  /// Rotates the laser's axes to the unit's.
  [[nodiscard]] SO3d q_unit_laser() const;
  /// The unit's axes to the robot's: by transforms, else by --forward.
  [[nodiscard]] SO3d q_base_unit(const UnitReadings& readings, const Recording& log) const;
};

}  // namespace wayfare::examples
