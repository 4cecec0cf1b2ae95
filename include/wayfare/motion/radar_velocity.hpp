#pragma once

// Ego-velocity of a radar from the radial speeds of one frame.

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/sensors/radar_scan.hpp>

namespace wayfare {

struct RadarVelocityOptions {
  /// Two unknowns instead of three, for a radar that measures no elevation or moves in a plane.
  bool plane = false;
  /// Nearer points are on the radar's own carrier, m.
  double min_range_m = 0.25;
  double min_snr_db = 0.0;
  /// A point whose radial speed has a larger residual is moving or a ghost, m/s. Covers part of the
  /// width of a Doppler bin and the effect of bearing errors.
  double inlier_m_s = 0.15;
  /// Smallest standard deviation of a radial speed, m/s, where the residuals are smaller: rounding
  /// to a bin of 0.12 m/s gives 0.035.
  double doppler_sigma_m_s = 0.035;
  /// Triples (pairs in the plane) drawn; 100 contain one without outliers with probability 0.9999
  /// where half the points are outliers.
  std::size_t draws = 100;
};

struct RadarVelocity {
  LogTime time;
  /// Of the radar over ground, in its own axes; z is 0 in the plane.
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::vector<bool> inlier;  ///< of each point of the frame
  std::size_t points = 0;    ///< beyond min_range_m and above min_snr_db
  std::size_t inliers = 0;
  double residual_m_s = 0.0;  ///< root mean square of the inliers' residuals
};

/// Static points have the radial speed -v p / |p|. Takes the triple with the smallest truncated
/// cost over all points, then least squares on its inliers (Kellner et al. 2013 in the plane; Doer
/// and Trommer 2020 in space). The same generator gives the same result. Errors: fewer points than
/// unknowns plus one, fewer than half of them inliers, or unobservable directions.
[[nodiscard]] Result<RadarVelocity> radar_velocity(const RadarScan& scan, Rng rng,
                                                   const RadarVelocityOptions& options = {});

}  // namespace wayfare
