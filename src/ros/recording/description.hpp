#pragma once

// What a robot description (URDF) tells about wheels and radar.

#include <optional>
#include <string>
#include <string_view>

#include <wayfare/ros/recording.hpp>

namespace wayfare::ros {

struct RobotDescription {
  std::optional<double> wheel_radius_m;  ///< of both wheels
  /// From the right wheel to the left one, negative if they are exchanged; none if the joints'
  /// parents differ.
  std::optional<double> wheel_base_m;
  std::optional<double> radar_max_speed_mps;  ///< of `urdf_of` only
};

/// Of the joints of two wheels. A wheel's radius is that of the first cylinder or sphere of its
/// link. Parts that are missing or malformed are none. Errors: wheels of different radii.
[[nodiscard]] Result<RobotDescription> describe(std::string_view urdf, std::string_view left,
                                                std::string_view right);

/// A description from which `describe` restores the distance of the wheels and the radar's largest
/// speed bit for bit; empty if the recording has neither wheels nor that speed.
[[nodiscard]] std::string urdf_of(const Recording& recording, const RobotTopics& topics);

}  // namespace wayfare::ros
