#pragma once

// What localisation asks of a pose in the plane or in space.

#include <cmath>
#include <cstddef>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/filter/particle_filter.hpp>
#include <wayfare/filter/pose_bins.hpp>

namespace wayfare::detail {

template <class Pose>
struct PoseBinsOf;
template <>
struct PoseBinsOf<SE2d> {
  using Type = PoseBins;
};
template <>
struct PoseBinsOf<SE3d> {
  using Type = SpatialPoseBins;
};

template <class Pose>
inline constexpr int kPlaceDof = Pose::Vector::RowsAtCompileTime;

[[nodiscard]] inline double turn_of(const SE2d& motion) {
  return std::abs(motion.heading().radians());
}
[[nodiscard]] inline double turn_of(const SE3d& motion) { return motion.rotation().log().norm(); }

[[nodiscard]] inline double turn_between(const SE2d& a, const SE2d& b) {
  return std::abs((a.heading() - b.heading()).wrapped().radians());
}
[[nodiscard]] inline double turn_between(const SE3d& a, const SE3d& b) {
  return turn_of(a.inverse() * b);
}

/// The pose with normal noise, in the axes of the map.
template <class Pose>
[[nodiscard]] Pose with_noise(const Pose& pose, double sigma_m, double sigma_rad, Rng& rng) {
  TangentOf<Pose> noise;
  for (auto& n : noise) n = rng.normal();
  const typename Pose::Vector place =
      pose.translation() + sigma_m * noise.template head<kPlaceDof<Pose>>();
  constexpr int kTurn = Pose::kDof - kPlaceDof<Pose>;
  return Pose(place, pose.rotation().plus((sigma_rad * noise.template tail<kTurn>()).eval()));
}

/// In the plane, the mean of the positions and the direction of the mean heading vector.
template <ParticleStorage P, class Members>
requires std::same_as<typename P::Value, SE2d>
[[nodiscard]] SE2d mean_pose(const P& particles, std::span<const double> weights,
                             const Members& members) {
  double sum = 0.0, c = 0.0, s = 0.0;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  for (const auto i : members) {
    const SE2d& pose = particles.state(i);
    sum += weights[i];
    place += weights[i] * pose.translation();
    c += weights[i] * pose.rotation().cos();
    s += weights[i] * pose.rotation().sin();
  }
  return SE2d(place.x() / sum, place.y() / sum, Angle::radians(std::atan2(s, c)));
}
template <ParticleStorage P, class Members>
[[nodiscard]] typename P::Value mean_pose(const P& particles, std::span<const double> weights,
                                          const Members& members) {
  return intrinsic_mean(particles, weights, members);
}

}  // namespace wayfare::detail
