#pragma once

// Models of odometry for particle filters: from a measured increment to the distribution of the
// motion.

#include <concepts>
#include <type_traits>

#include <Eigen/Core>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/gaussian_sampler.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/motion/differential_drive_model.hpp>

namespace wayfare {

namespace detail {

template <class M, class Pose>
inline constexpr bool kIsMotion = std::convertible_to<M, Gaussian<Pose>> ||
                                  requires(const M& sampler, const Pose& x, Rng& rng) {
  { sampler(x, rng) } -> std::convertible_to<Pose>;
};

}  // namespace detail

/// Required: `motion(increment)`, of the increment T_before_after of odometry: the distribution of
/// the motion, a Gaussian<Pose>, or a callable `(pose, rng)` that draws the pose after it.
/// Optional: `prediction(increment)`, the same of an increment at constant velocity, where odometry
/// is missing or refused; else `motion` is used.
template <class M, class Pose>
concept OdometryModel = requires(const M& model, const Pose& increment) {
  requires detail::kIsMotion<decltype(model.motion(increment)), Pose>;
};

namespace detail {

/// What a type lacks to be a model of odometry, in words.
template <class M, class Pose>
consteval bool check_odometry_model() {
  constexpr bool kHasMotion = requires(const M& model, const Pose& increment) {
    model.motion(increment);
  };
  static_assert(kHasMotion,
                "wayfare: a model of odometry has a const member motion(increment), which takes "
                "the increment of the pose");
  if constexpr (kHasMotion)
    static_assert(OdometryModel<M, Pose>,
                  "wayfare: motion(increment) of a model of odometry returns a Gaussian of the "
                  "pose, or a callable (pose, rng) that returns the pose after the motion");
  return true;
}

/// A callable (pose, rng) of a motion.
template <class Pose, class Motion>
[[nodiscard]] auto motion_sampler(const Motion& motion) {
  if constexpr (std::convertible_to<Motion, Gaussian<Pose>>) {
    return [draw = GaussianSampler<Pose>(motion)](const Pose& x, Rng& rng) -> Pose {
      return x * draw(rng);
    };
  } else {
    return motion;
  }
}

}  // namespace detail

/// Draws the motion of an odometry increment: `sampler(pose, rng)` is the pose after it.
template <class Pose, class Model>
[[nodiscard]] auto sampler_of_odometry(const Model& model, const Pose& increment) {
  static_assert(detail::check_odometry_model<Model, Pose>());
  return detail::motion_sampler<Pose>(model.motion(increment));
}

/// Standard deviations that grow with the motion.
struct OdometryNoise {
  /// Noise of a measured increment.
  MotionNoise odometry{0.01, 0.20, 0.02, Angle::degrees(0.5), 0.20, 0.10};
  /// Noise of the constant-velocity prediction, used when odometry is missing or refused.
  MotionNoise constant_velocity{0.05, 0.50, 0.05, Angle::degrees(3.0), 0.4, 0.2};

  /// The measured increment with the noise `odometry`.
  [[nodiscard]] Gaussian<SE2d> motion(const SE2d& increment) const {
    return with_noise(increment, odometry);
  }
  /// An increment at constant velocity with the noise `constant_velocity`.
  [[nodiscard]] Gaussian<SE2d> prediction(const SE2d& increment) const {
    return with_noise(increment, constant_velocity);
  }

 private:
  static Gaussian<SE2d> with_noise(const SE2d& increment, const MotionNoise& noise) {
    // Options that are not finite: the motion is unknown, the particles stay finite.
    constexpr double kUnknown = 1e3;
    const Eigen::Vector3d sigma = sigma_of(increment, noise);
    const Eigen::Vector3d known = (sigma.array().abs() < kUnknown).select(sigma, kUnknown);
    return {increment, known.cwiseAbs2().asDiagonal()};
  }
};

}  // namespace wayfare
