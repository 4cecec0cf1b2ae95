#pragma once

// How a radar moves, from the radial speeds of one frame alone.

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/sensors/radar_scan.hpp>

namespace wayfare {

struct RadarVelocityOptions {
  /// The radar measures no elevation, or does not move up and down: two unknowns instead of three.
  bool plane = false;
  /// Nearer points are the radar's own carrier, m.
  double min_range_m = 0.25;
  double min_snr_db = 0.0;
  /// A point whose radial speed is off by more than this moves by itself, or is a ghost, m/s. Some
  /// of the width of a Doppler bin, and what an error of the bearing makes of the speed.
  double inlier_m_s = 0.15;
  /// Standard deviation of a radial speed, m/s, where the residuals claim less: a bin of 0.12 m/s
  /// is rounded by 0.035.
  double doppler_sigma_m_s = 0.035;
  /// Triples (pairs in the plane) drawn; 100 hold a pure one with 0.9999 where half the points are
  /// false.
  std::size_t draws = 100;
};

struct RadarVelocity {
  LogTime time;
  /// Of the radar over ground, in its own axes; up is 0 in the plane.
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::vector<bool> inlier;  ///< of each point of the frame
  std::size_t points = 0;    ///< that were far and strong enough
  std::size_t inliers = 0;
  double residual_m_s = 0.0;  ///< root mean square of the inliers'
};

/// What stands still is seen with the radial speed -v p / |p|. By the triple on which most points
/// agree, then by least squares on these (Kellner et al. 2013 in the plane; Doer and Trommer 2020
/// in space). The same generator gives the same result. Errors: fewer than one point more than
/// unknowns, fewer than half of them agreeing on anything, or directions that leave one of them
/// open.
[[nodiscard]] Result<RadarVelocity> radar_velocity(const RadarScan& scan, Rng rng,
                                                   const RadarVelocityOptions& options = {});

}  // namespace wayfare
