#pragma once

#include <array>
#include <cmath>

#include <wayfare/core/se2.hpp>
#include <wayfare/nav/corridor_ins.hpp>

#include "nav/corridor_ins/wall_states.hpp"

namespace wayfare::corridor {

/// The filter at the start, at rest.
[[nodiscard]] inline Filter start_filter(const CorridorInsOptions& o, const SE2d& start) {
  CorridorVector x = CorridorVector::Zero(), sigma = CorridorVector::Constant(1.0);
  x[kX] = start.x(), x[kY] = start.y(), x[kHeading] = start.heading().radians();
  x[kBiasConstant] = o.start_bias_value_rad_s;
  sigma[kX] = sigma[kY] = o.start_position_m;
  sigma[kHeading] = o.start_heading_rad;
  sigma[kSpeed] = sigma[kSpeedX] = sigma[kSpeedY] = 1e-6;
  sigma[kAcceleration] = o.noise.acceleration_sigma_m_s2;
  sigma[kBiasWalk] = o.noise.bias_sigma_rad_s;
  sigma[kBiasConstant] = o.start_bias_rad_s;
  sigma[kBiasDrift] = o.start_drift_rad_s2;
  sigma[kScale] = o.start_scale;
  return {x, sigma.cwiseAbs2().asDiagonal()};
}

/// Whether heading or position are unknown: heading errors beyond a rotation cannot be linearised,
/// and the rounding errors of larger covariances exceed the accuracy of walls.
[[nodiscard]] inline bool is_lost(const CorridorMatrix& p) {
  return p(kHeading, kHeading) > 100.0 || p(kX, kX) + p(kY, kY) > 1e6;
}

/// The filter at the pose of `lost`, which is taken as unknown; the speed and its errors are kept.
[[nodiscard]] inline Filter restart_filter(const CorridorInsOptions& o, const Filter& lost) {
  const CorridorVector& old = lost.state();
  const Angle heading = Angle::radians(old[kHeading]).wrapped();
  Filter filter = start_filter(o, SE2d(old[kX], old[kY], heading));
  CorridorVector x = filter.state();
  CorridorMatrix p = filter.covariance();
  const std::array<int, 3> kept{kSpeed, kAcceleration, kScale};
  x(kept) = old(kept);
  p(kept, kept) = lost.covariance()(kept, kept);
  x[kSpeedX] = x[kSpeed] * std::cos(x[kHeading]), x[kSpeedY] = x[kSpeed] * std::sin(x[kHeading]);
  p(kSpeedX, kSpeedX) = p(kSpeedY, kSpeedY) = p(kSpeed, kSpeed) + x[kSpeed] * x[kSpeed];
  p(kX, kX) = p(kY, kY) = 1e4;
  p(kHeading, kHeading) = 10.0;
  return {x, p};
}

}  // namespace wayfare::corridor
