#pragma once

// A curve in three dimensions over time with continuous second derivative, fitted to samples.

#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>

namespace wayfare::sim {

/// A constraint on a curve: its value, or its first derivative, at a time.
struct CurveSample {
  /// What a sample gives.
  enum class Of {
    value,       ///< of the curve
    derivative,  ///< the first, by time
  };

  double time_s = 0.0;                              ///< of the sample
  Eigen::Vector3d value = Eigen::Vector3d::Zero();  ///< or derivative
  double sigma = 1.0;                               ///< of each component
  Of of = Of::value;                                ///< value or first derivative
};

/// Knots and smoothness of a SmoothCurve.
struct CurveFit {
  double knot_spacing_s = 0.1;  ///< between knots
  /// Standard deviation of the third derivative (unit of the value per s³): smaller is smoother.
  double third_derivative_sigma = 1e3;
};

/// A uniform cubic B-spline (de Boor 1978, chapter IX): second derivative continuous, third
/// constant between knots.
class SmoothCurve {
 public:
  /// A point of the curve.
  struct Point {
    Eigen::Vector3d value,  ///< at the time
        first,              ///< first derivative
        second;             ///< second derivative
  };

  /// The curve over [begin_s, end_s] that minimises the squared residuals of `samples`, each over
  /// its σ, plus the integral of the squared third derivative over its σ. Errors: an empty span,
  /// values that are not finite, and fewer than three values.
  [[nodiscard]] static Result<SmoothCurve> fit(std::span<const CurveSample> samples, double begin_s,
                                               double end_s, const CurveFit& options = {});

  /// Constant outside [begin_s, end_s].
  [[nodiscard]] Point at(double time_s) const;
  /// First time.
  [[nodiscard]] double begin_s() const { return begin_s_; }
  /// Last time.
  [[nodiscard]] double end_s() const { return end_s_; }

 private:
  double begin_s_ = 0.0, end_s_ = 0.0, spacing_s_ = 1.0;
  std::vector<Eigen::Vector3d> control_;
};

}  // namespace wayfare::sim
