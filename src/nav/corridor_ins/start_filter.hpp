#pragma once

#include <cmath>

#include <wayfare/core/se2.hpp>
#include <wayfare/nav/corridor_ins.hpp>

#include "nav/corridor_ins/wall_states.hpp"

namespace wayfare::corridor {

/// The filter at the start, at rest.
[[nodiscard]] inline Filter start_filter(const CorridorInsOptions& o, const SE2d& start) {
  CorridorState x, sigma = x.plus(CorridorState::Tangent::Ones());
  x.get<Position>() = start.translation();
  x.get<Heading>()[0] = start.heading().radians();
  x.get<Bias>()[0] = o.start_bias_value_rad_s;
  sigma.get<Position>().setConstant(o.start_position_m);
  sigma.get<Speed>().setConstant(1e-6);
  sigma.get<Velocity>().setConstant(1e-6);
  sigma.get<Heading>()[0] = o.start_heading_rad;
  sigma.get<Acceleration>()[0] = o.noise.acceleration_sigma_m_s2;
  sigma.get<BiasWalk>()[0] = o.noise.bias_sigma_rad_s;
  sigma.get<Bias>() << o.start_bias_rad_s, o.start_drift_rad_s2;
  sigma.get<Scale>()[0] = o.start_scale;
  return {x, sigma.minus(CorridorState{}).cwiseAbs2().asDiagonal()};
}

/// Whether heading or position are unknown: heading errors beyond a rotation cannot be linearised,
/// and the rounding errors of larger covariances exceed the accuracy of walls.
[[nodiscard]] inline bool is_lost(const Filter::Square& p) {
  return variances<Heading>(p)[0] > 100.0 || variances<Position>(p).sum() > 1e6;
}

/// The filter at the pose of `lost`, which is taken as unknown; the speed and its errors are kept.
[[nodiscard]] inline Filter restart_filter(const CorridorInsOptions& o, const Filter& lost) {
  CorridorState x = lost.state();
  const Angle heading = Angle::radians(x.get<Heading>()[0]).wrapped();
  const Filter start = start_filter(o, SE2d(x.get<Position>().x(), x.get<Position>().y(), heading));
  const double speed = x.get<Speed>()[0];
  x = start.state();
  x.get<Speed>() = lost.state().get<Speed>();
  x.get<Acceleration>() = lost.state().get<Acceleration>();
  x.get<Scale>() = lost.state().get<Scale>();
  x.get<Velocity>() = speed * SO2d(heading).matrix().col(0);
  Filter::Square p = start.covariance();
  constexpr auto kKept = CorridorState::indices<Speed, Acceleration, Scale>();
  p(kKept, kKept) = lost.covariance()(kKept, kKept);
  variances<Velocity>(p).setConstant(variances<Speed>(p)[0] + speed * speed);
  variances<Position>(p).setConstant(1e4);
  variances<Heading>(p)[0] = 10.0;
  return {x, p};
}

}  // namespace wayfare::corridor
