#pragma once

// Errors of a run against its reference.

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

/// The reference interpolated between its states: cubic with velocities, else linear. Nothing
/// outside of it and within gaps of more than 1.5 s.
[[nodiscard]] std::optional<NavState> reference_at(const NavTrajectory& reference,
                                                   bool has_velocity, LogTime time);

/// The run interpolated between its points.
[[nodiscard]] std::optional<GnssInsPoint> point_at(const std::vector<GnssInsPoint>& points,
                                                   LogTime time);

/// The state of a point fixed to the body.
[[nodiscard]] NavState at_lever_arm(const NavState& unit, const Eigen::Vector3d& lever_arm_m,
                                    const Eigen::Vector3d& body_rate_radps);

/// Estimate minus reference over time, and the filter's standard deviation: position and velocity
/// north, east, down (m, m/s), roll, pitch, yaw (degrees). NaN if unknown.
struct NavErrors {
  static constexpr std::size_t kCount = 9;
  std::vector<double> time_s;  ///< since the unit's first sample
  std::array<std::vector<double>, kCount> error, sigma;

  [[nodiscard]] double horizontal(std::size_t i) const;
};

/// At every state of the reference. If it has no attitude, yaw is compared with its course at
/// speeds above 3 m/s.
[[nodiscard]] NavErrors nav_errors(const std::vector<GnssInsPoint>& points,
                                   const NavRecording& recording, const NavConfig& config);

/// Single-point position of each epoch, or the fixes.
struct PlainGnss {
  std::vector<double> time_s;
  std::vector<Geodetic> position;
  std::vector<Eigen::Vector3d> error_ned_m;  ///< NaN outside of the reference
};
[[nodiscard]] PlainGnss plain_gnss(const NavRecording& recording);

}  // namespace wayfare::examples
