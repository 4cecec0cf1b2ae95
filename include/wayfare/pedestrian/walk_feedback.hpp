#pragma once

// Feedback of a map to dead reckoning: step scale, walking direction, and the variance of a matched
// heading for the filter that provided its prior.

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/filter/sequential_update.hpp>

namespace wayfare {

/// Spacing and noise of headings by the map.
struct MapHeadingParameters {
  double spacing_s = 1.0;             ///< between headings used
  Angle sigma = Angle::degrees(0.5);  ///< of the map's heading, in addition to the match's
  double correlation_s = 5.0;         ///< of the map's heading error
  double largest_share = 0.8;         ///< of the prior in a match; above it the match is not used
};

/// A matched heading is not independent: its prior comes from the same gyro, and scans matched to
/// one map share its error. The returned variance removes the prior's share and replaces the
/// correlated error by an equivalent independent one.
class MapHeading {
 public:
  /// Before the first heading.
  explicit MapHeading(const MapHeadingParameters& p = {}) : p_(p) {}

  /// Variance to use for a matched heading, rad²; none if it must not be used. `match`: its
  /// variance from the scan alone, `prior`: that of the predicted heading, rad².
  [[nodiscard]] std::optional<double> independent_variance(LogTime time, double match,
                                                           double prior) {
    if (!(match > 0.0) || !(prior > 0.0) || !std::isfinite(match + prior)) return std::nullopt;
    const double dt = last_ ? to_seconds(time - *last_) : p_.correlation_s;
    if (last_ && dt >= 0.0 && dt < p_.spacing_s) return std::nullopt;
    // The matched heading is (1 − s)·scan + s·prior: its innovation is 1 − s times the scan's.
    const double share = match / (match + prior);
    if (share > p_.largest_share) return std::nullopt;
    last_ = time;
    const double sigma = p_.sigma.radians();
    // The mean of a Gauss-Markov error sampled every dt has (1 + ρ)/(1 − ρ) times the variance of
    // that of a white one.
    const double rho = std::exp(-std::abs(dt) / p_.correlation_s);
    return (match + sigma * sigma * (1.0 + rho) / (1.0 - rho)) / ((1.0 - share) * (1.0 - share));
  }

 private:
  MapHeadingParameters p_;
  std::optional<LogTime> last_;
};

/// Priors and noises of a WalkFeedback.
struct WalkFeedbackParameters {
  double scale_sigma = 0.06;  ///< prior, of the logarithm of the step scale
  double direction_sigma =
      0.3;  ///< prior, of the walking direction relative to the unit's axis, rad
  /// Random walk of the direction, rad/√s: the wearer looks around.
  double direction_wander = 0.15;
  double window_m = 1.5;        ///< distance over which map and steps are compared
  double sigma_m = 0.06;        ///< of the map's displacement over this distance
  double scale_wander = 0.002;  ///< of the logarithm, over this distance
};

/// Two scalar Kalman filters: the logarithm of the step scale and the angle from the steps'
/// direction to the direction of motion.
class WalkFeedback {
 public:
  /// At the priors.
  explicit WalkFeedback(const WalkFeedbackParameters& p = {})
      : p_(p), log_scale_(0.0, p.scale_sigma), direction_(0.0, p.direction_sigma) {}

  /// True length per length by steps.
  [[nodiscard]] double scale() const { return std::exp(log_scale_.value); }
  /// Of motion relative to that of the steps, counter-clockwise.
  [[nodiscard]] Angle direction() const { return Angle::radians(direction_.value); }

  /// At each scan: position by the map and by the uncorrected steps, in frames with the same
  /// heading; `length_known`: whether the scene constrains the motion along the path. A position
  /// that is not finite is ignored.
  void add(LogTime time, const Eigen::Vector2d& by_map_m, const Eigen::Vector2d& by_steps_m,
           bool length_known) {
    if (!std::isfinite(by_map_m.squaredNorm() + by_steps_m.squaredNorm())) return;
    if (!past_.empty()) {
      const double dt = std::clamp(to_seconds(time - past_.back().time), 0.0, 5.0);
      direction_.p(0, 0) += p_.direction_wander * p_.direction_wander * dt;
    }
    past_.push_back({time, by_map_m, by_steps_m, length_known});
    const Past& first = past_.front();
    const Eigen::Vector2d map = by_map_m - first.by_map_m, steps = by_steps_m - first.by_steps_m;
    if (!(steps.norm() >= p_.window_m)) {
      if (past_.size() > kMaxScans) past_.pop_front();
      return;
    }
    const double length = std::max(map.norm(), 0.3);
    if (map.norm() > 0.3 * steps.norm()) direction_.update(angle(steps, map), p_.sigma_m / length);
    const bool known =
        std::all_of(past_.begin(), past_.end(), [](const Past& p) { return p.length_known; });
    if (known && map.norm() > 0.5 * steps.norm() && map.norm() < 2.0 * steps.norm()) {
      log_scale_.p(0, 0) += p_.scale_wander * p_.scale_wander;
      log_scale_.update(std::log(map.norm() / steps.norm()), 2.0 * p_.sigma_m / length);
    }
    past_.erase(past_.begin(), past_.end() - 1);
  }

 private:
  static constexpr std::size_t kMaxScans = 400;
  struct Past {
    LogTime time;
    Eigen::Vector2d by_map_m, by_steps_m;
    bool length_known;
  };

  static double angle(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  /// A state of one number and its variance.
  struct Estimate {
    double value;
    SymmetricMatrix<double, 1> p;

    Estimate(double mean, double sigma) : value(mean) { p(0, 0) = sigma * sigma; }
    void update(double measured, double sigma) {
      std::array<double, 1> correction{};
      sequential_update(p, correction, IndexedRow<double, 0>{1.0}, measured - value, sigma * sigma);
      value += correction[0];
    }
  };

  WalkFeedbackParameters p_;
  Estimate log_scale_, direction_;
  std::deque<Past> past_;
};

}  // namespace wayfare
