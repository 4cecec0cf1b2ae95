#pragma once

// The gyro's bias from walking straight ahead: heuristic drift elimination (Borenstein and Ojeda
// 2010) with the bias as one number for the whole walk.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <wayfare/core/time.hpp>

namespace wayfare {

/// Disabled if the bias is zero.
struct StraightWalkParameters {
  double bias_sigma_radps = 0.0;  ///< prior, of the bias about the vertical
  double window_s = 3.0;          ///< averaging time of the heading rates
  double sigma_radps = 0.005;     ///< of a heading rate while walking straight
  double straight_part = 0.2;     ///< of the windows; others have any rate
};

/// Heading drift from a grid filter of the bias: bends and drift are only separable over time, and
/// the rate that recurs most often is the bias.
class StraightWalk {
 public:
  /// Without steps.
  explicit StraightWalk(const StraightWalkParameters& p) : p_(p) {}

  /// After a step, with the unwrapped gyro heading, rad: returns its drift, rad.
  double step(LogTime time, double heading) {
    if (!(p_.bias_sigma_radps > 0.0)) return 0.0;
    const bool pause = count_ > 0 && !(std::abs(to_seconds(time - past(0).time)) < 2.0);
    if (pause) count_ = 0;
    if (!started_) start_ = time;
    started_ = true;
    newest_ = (newest_ + 1) % kSteps;
    steps_[newest_] = {time, heading};
    count_ = std::min(count_ + 1, kSteps);
    for (std::size_t age = 1; age < count_; ++age) {
      const double span = to_seconds(time - past(age).time);
      if (span < p_.window_s) continue;
      update((heading - past(age).heading) / span, 1.0 / double(age));
      break;
    }
    return bias_ * to_seconds(time - start_);
  }

  /// Estimated bias of the rate about the vertical.
  [[nodiscard]] double bias_radps() const { return bias_; }

 private:
  struct Past {
    LogTime time;
    double heading = 0.0;
  };
  static constexpr std::size_t kSteps = 32, kCells = 121;
  static constexpr double kRange = 3.0;  ///< of the grid, standard deviations

  [[nodiscard]] const Past& past(std::size_t age) const {
    return steps_[(newest_ + kSteps - age) % kSteps];
  }
  [[nodiscard]] double in_sigmas(std::size_t cell) const {
    return kRange * (2.0 * double(cell) / double(kCells - 1) - 1.0);
  }

  /// Bayes' rule with a window's mean rate; overlapping windows each count for a `part`.
  void update(double rate, double part) {
    constexpr double kAnyTurn_radps = 1.0;
    const double straight = p_.straight_part / (2.5066 * p_.sigma_radps);
    const double other = (1.0 - p_.straight_part) / kAnyTurn_radps;
    double highest = -1e300;
    for (std::size_t i = 0; i < kCells; ++i) {
      const double off = (rate - in_sigmas(i) * p_.bias_sigma_radps) / p_.sigma_radps;
      log_[i] += part * std::log(straight * std::exp(-0.5 * off * off) + other);
      const double prior = -0.5 * in_sigmas(i) * in_sigmas(i);
      highest = std::max(highest, log_[i] + prior);
    }
    double sum = 0.0, moment = 0.0;
    for (std::size_t i = 0; i < kCells; ++i) {
      const double w = std::exp(log_[i] - 0.5 * in_sigmas(i) * in_sigmas(i) - highest);
      sum += w;
      moment += w * in_sigmas(i);
    }
    bias_ = p_.bias_sigma_radps * moment / sum;
  }

  StraightWalkParameters p_;
  std::array<Past, kSteps> steps_;
  std::array<double, kCells> log_{};
  LogTime start_;
  std::size_t newest_ = 0, count_ = 0;
  double bias_ = 0.0;
  bool started_ = false;
};

}  // namespace wayfare
