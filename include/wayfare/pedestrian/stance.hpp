#pragma once

// What a stance statistic of the foot tracker is: a number from the readings around a time.
//
//   struct Magnitude {                                  // MAG of Skog et al. 2010
//     double gravity_mps2 = 9.80665, sigma_mps2 = 0.2;
//     double operator()(const StanceWindow& window) const {
//       double sum = 0.0;
//       for (const ImuSample& s : window) {
//         const double off = (s.specific_force_mps2.norm() - gravity_mps2) / sigma_mps2;
//         sum += off * off;
//       }
//       return sum / static_cast<double>(window.size());
//     }
//   };
//   BasicFootTracker tracker(FootParameters{}, Magnitude{});

#include <concepts>
#include <cstddef>
#include <deque>

#include <Eigen/Core>

#include <wayfare/pedestrian/parameters.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// A reading with its statistic, as the foot tracker keeps it.
struct FootReading : ImuSample {
  double statistic = 0.0;  ///< at the reading's time
  bool stillest = false;   ///< a local minimum of the statistic
};

/// The readings within half of FootParameters::stance_window_s before and after one, in the order
/// of time: one or more ImuSample with finite numbers.
class StanceWindow {
 public:
  using Iterator = std::deque<FootReading>::const_iterator;  ///< over readings in order of time

  /// The readings [begin, end).
  StanceWindow(Iterator begin, Iterator end) : begin_(begin), end_(end) {}
  /// First reading.
  [[nodiscard]] Iterator begin() const { return begin_; }
  /// Past the last reading.
  [[nodiscard]] Iterator end() const { return end_; }
  /// Number of readings.
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(end_ - begin_); }

 private:
  Iterator begin_, end_;
};

/// A const callable that returns a number of zero or more, about one in stance and larger in
/// motion; anything else counts as motion. FootParameters compares it with quiet_statistic and
/// rest_statistic. See testing::StanceLaws.
template <class S>
concept ZeroVelocityStatistic = std::copy_constructible<S> &&
    requires(const S& statistic, const StanceWindow& window) {
  { statistic(window) } -> std::convertible_to<double>;
};

namespace detail {

/// What a type lacks to be a stance statistic, in words.
template <class S>
consteval bool check_stance_statistic() {
  static_assert(ZeroVelocityStatistic<S>,
                "wayfare: a stance statistic is a value with a const member "
                "operator()(const StanceWindow&), which returns a double");
  return true;
}

}  // namespace detail

/// Stance statistic over readings [begin, end) (Skog et al. 2010 (12) for SHOE, (15) for ARED),
/// with mean about one in stance.
template <class Iterator>
[[nodiscard]] double stance_statistic(Iterator begin, Iterator end, const FootParameters& p) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (auto i = begin; i != end; ++i) mean += i->specific_force_mps2;
  const double norm = mean.norm();
  const Eigen::Vector3d gravity =
      norm > 0.0 ? Eigen::Vector3d(mean * (p.gravity_mps2 / norm)) : mean;
  const double force2 = p.stance_force_sigma * p.stance_force_sigma;
  const double rate2 = p.stance_rate_sigma * p.stance_rate_sigma;
  double sum = 0.0;
  int n = 0;
  for (auto i = begin; i != end; ++i, ++n) {
    sum += i->angular_rate_radps.squaredNorm() / rate2;
    if (p.statistic == StanceStatistic::shoe)
      sum += (i->specific_force_mps2 - gravity).squaredNorm() / force2;
  }
  return n > 0 ? sum / n : 0.0;
}

/// SHOE or ARED, by FootParameters::statistic.
class ShoeOrAred {
 public:
  ShoeOrAred() = default;
  /// Of the parameters its window, standard deviations, gravity and `statistic` are used.
  explicit ShoeOrAred(const FootParameters& parameters) : p_(parameters) {}
  /// SHOE or ARED of the window.
  double operator()(const StanceWindow& window) const {
    return stance_statistic(window.begin(), window.end(), p_);
  }

 private:
  FootParameters p_;
};

}  // namespace wayfare
