#pragma once

// By how much a run misses its reference.

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/nav/gnss_ins.hpp>

#include "nav_config.hpp"
#include "nav_recording.hpp"

namespace wayfare::examples {

/// Seconds since the unit's first sample.
[[nodiscard]] double since_start(const NavRecording& recording, LogTime time);

/// The reference between its states: cubic where it knows velocities, linear otherwise. Nothing
/// outside of it, and within gaps of more than 1.5 s.
[[nodiscard]] std::optional<NavState> reference_at(const NavTrajectory& reference,
                                                   bool has_velocity, LogTime time);

/// The run between two of its points.
[[nodiscard]] std::optional<GnssInsPoint> point_at(const std::vector<GnssInsPoint>& points,
                                                   LogTime time);

/// The same instant at a point fixed to the body, turning with it.
[[nodiscard]] NavState at_lever_arm(const NavState& unit, const Eigen::Vector3d& lever_arm_m,
                                    const Eigen::Vector3d& body_rate_radps);

/// Estimate less reference over time, and the standard deviation the filter gives it: position and
/// velocity north, east, down (m, m/s), roll, pitch, yaw (degrees). NaN where not known.
struct NavErrors {
  static constexpr std::size_t kCount = 9;
  std::vector<double> time_s;  ///< since the unit's first sample
  std::array<std::vector<double>, kCount> error, sigma;

  [[nodiscard]] double horizontal(std::size_t i) const;
};

/// At every state of the reference. Without attitude in it, yaw is compared to its course wherever
/// it is faster than 3 m/s.
[[nodiscard]] NavErrors nav_errors(const std::vector<GnssInsPoint>& points,
                                   const NavRecording& recording, const NavConfig& config);

/// Position of each epoch on its own, without the inertial unit.
struct PlainGnss {
  std::vector<double> time_s;
  std::vector<Geodetic> position;
  std::vector<Eigen::Vector3d> error_ned_m;  ///< NaN where the reference does not reach
};
[[nodiscard]] PlainGnss plain_gnss(const NavRecording& recording);

}  // namespace wayfare::examples
