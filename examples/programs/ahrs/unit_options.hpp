#pragma once

// Options of the SLAM programs for an inertial unit beside the range finder.

#include <optional>
#include <string>

#include <wayfare/core/so3.hpp>
#include <wayfare/sensors/recording.hpp>

#include "recording.hpp"

namespace wayfare::examples {

struct UnitReadings {
  io::MargFile file;
  std::optional<SO3d> q_base_unit = {};  ///< from transforms of a ROS recording
};

struct UnitOptions {
  std::string path;  ///< empty: the unit in the log, if any
  bool none = false;
  std::string forward = "x";
  RecordingOptions recording;

  void add_options(CommandLine& app);
  /// The readings of --unit, else those of a unit in the log; with the stamps of the log. Nothing
  /// without a unit, or if `none` is set. A unit in the log that was not requested and cannot be
  /// used is reported on standard error.
  [[nodiscard]] Result<std::optional<UnitReadings>> read(const std::string& log,
                                                         const ros::TopicNames& topics) const;
  /// The unit's axis along which the laser's x points; z of both points up.
  [[nodiscard]] Eigen::Vector3d forward_axis() const;
  /// From the laser's axes to the unit's.
  [[nodiscard]] SO3d q_unit_laser() const;
  /// From the unit's axes to the robot's, by transforms, else by --forward.
  [[nodiscard]] SO3d q_base_unit(const UnitReadings& readings, const Recording& log) const;
};

}  // namespace wayfare::examples
