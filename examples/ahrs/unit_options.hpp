#pragma once

// How the SLAM programs are told about an inertial unit beside the range finder.

#include <string>

#include <wayfare/core/so3.hpp>

#include "recording.hpp"

namespace wayfare::examples {

struct UnitOptions {
  std::string path;  ///< empty: there is none
  std::string forward = "x";
  RecordingOptions recording;

  /// The option --unit, for who requires it.
  Option describe(CommandLine& app);
  /// Its recording, stamped as the log is.
  [[nodiscard]] Result<io::MargFile> read(const ros::TopicNames& log) const;
  /// The unit's axis along which the laser's x points; z of both points up.
  [[nodiscard]] Eigen::Vector3d forward_axis() const;
  /// Rotates the laser's axes to the unit's.
  [[nodiscard]] SO3d q_unit_laser() const;
};

}  // namespace wayfare::examples
