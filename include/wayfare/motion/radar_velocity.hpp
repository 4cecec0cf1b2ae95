#pragma once

// Ego-velocity of a radar from the radial speeds of one frame.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare {

/// Which points radar_velocity uses, and when they agree.
struct RadarVelocityOptions {
  /// Two unknowns instead of three, for a radar that measures no elevation or moves in a plane.
  bool plane = false;
  /// Nearer points are on the radar's own carrier, m.
  double min_range_m = 0.25;
  double min_snr_db = 0.0;  ///< dB; points below are not used
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

/// Ego-velocity estimated from one frame.
struct RadarVelocity {
  LogTime time;  ///< of the frame
  /// Of the radar over ground, in its own axes; z is 0 in the plane.
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  /// Of the velocity, (m/s)²; in the plane zero for z.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::vector<bool> inlier;   ///< of each point of the frame
  std::size_t points = 0;     ///< beyond min_range_m and above min_snr_db
  std::size_t inliers = 0;    ///< points whose residual is within inlier_m_s
  double residual_m_s = 0.0;  ///< root mean square of the inliers' residuals
};

namespace detail {

/// The radial speeds of a frame's points as linear equations of the radar's velocity.
class DopplerEquations {
 public:
  /// The direction to a point, and the speed of approach.
  struct Equation {
    Eigen::Vector3d direction;
    double approach_m_s = 0.0;
    std::size_t point = 0;

    [[nodiscard]] double residual(const Eigen::Vector3d& v) const {
      return direction.dot(v) - approach_m_s;
    }
  };
  /// HᵀH and Hᵀd of some equations; in the plane the third unknown is fixed at zero.
  struct Normal {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();

    explicit Normal(bool plane) { A(2, 2) = plane ? 1.0 : 0.0; }
    void add(const Equation& equation) {
      A += equation.direction * equation.direction.transpose();
      b += equation.approach_m_s * equation.direction;
    }
    [[nodiscard]] Eigen::Vector3d solution() const { return A.ldlt().solve(b); }
    /// Information in the worst direction; 0: none.
    [[nodiscard]] double smallest_eigenvalue() const {
      return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(A, Eigen::EigenvaluesOnly)
          .eigenvalues()[0];
    }
  };

  DopplerEquations(const RadarScan& scan, const RadarVelocityOptions& options) : o_(options) {
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
      const RadarPoint& p = scan.points[i];
      const auto z = o_.plane ? 0.0 : static_cast<double>(p.z_m);
      const Eigen::Vector3d at(static_cast<double>(p.x_m), static_cast<double>(p.y_m), z);
      const double range = at.norm();
      if (!(range > 0.0 && range >= o_.min_range_m) || !std::isfinite(range) ||
          !std::isfinite(p.doppler_m_s) || !(static_cast<double>(p.snr_db) >= o_.min_snr_db))
        continue;
      all_.push_back({at / range, -static_cast<double>(p.doppler_m_s), i});
    }
  }
  [[nodiscard]] const std::vector<Equation>& all() const { return all_; }
  [[nodiscard]] std::size_t unknowns() const { return o_.plane ? 2 : 3; }

  [[nodiscard]] Eigen::Vector3d best_draw(Rng& rng) const {
    // Zero velocity is tested first, so that a frame without motion gives exactly that.
    Eigen::Vector3d best = Eigen::Vector3d::Zero();
    double lowest = cost(best);
    for (std::size_t i = 0; i < o_.draws; ++i) {
      const auto v = draw(rng);
      if (!v) continue;
      const double candidate = cost(*v);
      if (candidate < lowest) lowest = candidate, best = *v;
    }
    return best;
  }
  [[nodiscard]] Normal normal_of_inliers(const Eigen::Vector3d& v) const {
    Normal normal(o_.plane);
    for (const Equation& equation : all_)
      if (std::abs(equation.residual(v)) <= o_.inlier_m_s) normal.add(equation);
    return normal;
  }

 private:
  /// The solution of equations drawn without repetition; nothing where they hardly determine it.
  [[nodiscard]] std::optional<Eigen::Vector3d> draw(Rng& rng) const {
    Normal normal(o_.plane);
    std::array<std::size_t, 3> drawn{};
    for (std::size_t& k : std::span(drawn).first(unknowns())) {
      k = rng.below(all_.size());
      if (std::find(drawn.data(), &k, k) != &k) return std::nullopt;
      normal.add(all_[k]);
    }
    constexpr double kMinEigenvalue = 0.1;  // a tenth of the value for orthogonal directions
    const double volume = std::abs(normal.A.determinant());
    if (volume < kMinEigenvalue * kMinEigenvalue * kMinEigenvalue) return std::nullopt;
    return normal.solution();
  }
  /// Sum of squared residuals, truncated.
  [[nodiscard]] double cost(const Eigen::Vector3d& v) const {
    double sum = 0.0;
    for (const Equation& equation : all_) {
      const double r = equation.residual(v);
      sum += std::min(r * r, o_.inlier_m_s * o_.inlier_m_s);
    }
    return sum;
  }

  const RadarVelocityOptions& o_;
  std::vector<Equation> all_;
};

}  // namespace detail

/// Static points have the radial speed -v p / |p|. Takes the triple with the smallest truncated
/// cost over all points, then least squares on its inliers (Kellner et al. 2013 in the plane; Doer
/// and Trommer 2020 in space). The same generator gives the same result. Errors: fewer points than
/// unknowns plus one, fewer than half of them inliers, or unobservable directions.
[[nodiscard]] inline Result<RadarVelocity> radar_velocity(const RadarScan& scan, Rng rng,
                                                          const RadarVelocityOptions& o = {}) {
  const detail::DopplerEquations equations(scan, o);
  const std::size_t points = equations.all().size(), unknowns = equations.unknowns();
  const auto degenerate = [&](std::string what) {
    return Error{ErrorCode::degenerate, std::move(what), "radar frame"};
  };
  if (points <= unknowns)
    return degenerate("has " + std::to_string(points) + " points, for " + std::to_string(unknowns) +
                      " unknowns and one to check");
  RadarVelocity out;
  out.time = scan.time;
  out.points = points;
  out.velocity_m_s = equations.best_draw(rng);
  detail::DopplerEquations::Normal normal(o.plane);
  for (int i = 0; i < 3; ++i) {
    normal = equations.normal_of_inliers(out.velocity_m_s);
    if (normal.smallest_eigenvalue() < 1e-3)
      return degenerate("has points in too few directions to determine the velocity");
    out.velocity_m_s = normal.solution();
  }
  out.inlier.assign(scan.points.size(), false);
  double squares = 0.0;
  for (const auto& equation : equations.all()) {
    const double r = equation.residual(out.velocity_m_s);
    if (std::abs(r) > o.inlier_m_s) continue;
    out.inlier[equation.point] = true;
    ++out.inliers;
    squares += r * r;
  }
  if (out.inliers <= unknowns || 2 * out.inliers < points)
    return degenerate("has " + std::to_string(points) + " points, of which only " +
                      std::to_string(out.inliers) + " agree");
  out.residual_m_s = std::sqrt(squares / static_cast<double>(out.inliers));
  const double variance = std::max(squares / static_cast<double>(out.inliers - unknowns),
                                   o.doppler_sigma_m_s * o.doppler_sigma_m_s);
  out.covariance = variance * normal.A.inverse();
  if (o.plane) out.covariance(2, 2) = 0.0;
  return out;
}

}  // namespace wayfare
