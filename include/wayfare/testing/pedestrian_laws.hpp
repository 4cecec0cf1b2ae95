#pragma once

// The laws of step length models and of stance statistics, as checks on any type:
//
//   StepLengthLaws<MyLength>{MyLength{0.7}}.check();
//   StanceLaws<MyStatistic>{MyStatistic{}}.check();

#include <cmath>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/pedestrian/stance.hpp>
#include <wayfare/pedestrian/step_detector.hpp>

namespace wayfare::testing {

/// Fails the current test where a step length is none, or its factor does not scale it.
template <StepLengthModel M>
struct StepLengthLaws {
  M model;                 ///< under test
  double longest_m = 3.0;  ///< of the steps of a walk
  int trials = 100;        ///< number of steps of the walk
  std::uint64_t seed = 1;  ///< of the steps

  /// All laws that apply.
  void check() const {
    lengths_are_those_of_steps();
    if constexpr (ScaledStepLength<M>) factor_scales_all_lengths();
  }

  /// From 0 to `longest_m` in a walk; finite and not negative for the first step of one, which may
  /// have no interval and no swing.
  void lengths_are_those_of_steps() const {
    for (const Step& step : walk()) {
      const double length = model(step);
      EXPECT_TRUE(length >= 0.0 && length <= longest_m)
          << "length " << length << " m of a step of " << step.interval_s << " s";
      EXPECT_EQ(model(step), length) << "the same step has two lengths";
    }
    const double first = model(Step{LogTime(), 0.0, 0.0, 0.0, 0.0});
    EXPECT_TRUE(std::isfinite(first) && first >= 0.0)
        << "length " << first << " m of a step of 0 s";
  }

  /// Twice the factor gives twice the length, and calibrated() fits a walk of 100 m.
  void factor_scales_all_lengths() const requires ScaledStepLength<M> {
    M twice = model;
    twice.factor *= 2.0;
    double sum = 0.0;
    for (const Step& step : walk()) {
      EXPECT_NEAR(twice(step), 2.0 * model(step), 1e-9) << "factor";
      sum += model(step);
    }
    double fitted = 0.0;
    const M to_100_m = calibrated(model, walk(), 100.0);
    for (const Step& step : walk()) fitted += to_100_m(step);
    EXPECT_NEAR(fitted, sum > 0.0 ? 100.0 : 0.0, 1e-6) << "factor";
  }

 private:
  /// Steps from a stroll to a run.
  [[nodiscard]] std::vector<Step> walk() const {
    Rng rng(seed);
    std::vector<Step> steps;
    for (int i = 0; i < trials; ++i) {
      const double crest = rng.uniform(0.2, 15.0), trough = -rng.uniform(0.2, 15.0);
      steps.push_back({LogTime::from_nanoseconds(500'000'000 * (i + 1)), rng.uniform(0.25, 1.0),
                       crest, trough, 0.3 * (crest - trough), crest - trough});
    }
    return steps;
  }
};

/// Fails the current test where a statistic does not tell stance from swing.
template <ZeroVelocityStatistic S>
struct StanceLaws {
  S statistic;                    ///< under test
  double gravity_mps2 = 9.80665;  ///< of the readings at rest
  double quiet = 1.0;             ///< limit of the statistic of a unit at rest
  double moving = 10.0;           ///< least statistic of a unit in a swing
  bool any_mounting = true;       ///< whether the statistic is independent of the unit's mounting
  int trials = 50;                ///< attitudes and mountings tried
  std::uint64_t seed = 1;         ///< of the readings

  /// From 0 to `quiet` at rest in any attitude, at least `moving` in a swing, finite for all
  /// readings, and the same in every mounting.
  void check() const {
    Rng rng(seed);
    for (int trial = 0; trial < trials; ++trial) {
      SCOPED_TRACE("trial " + std::to_string(trial));
      const std::size_t n = 1 + rng.below(20);
      const SO3d mounting = SO3d::exp(3.0 * normal(rng));
      const double still = of(window(n, 0.0, mounting, rng));
      EXPECT_TRUE(still >= 0.0 && still <= quiet) << "at rest " << still;
      const Window swing = window(n, 1.0, mounting, rng);
      const double swung = of(swing);
      EXPECT_TRUE(std::isfinite(swung) && swung >= moving) << "in a swing " << swung;
      const double saturated = of(window(n, 30.0, mounting, rng));
      EXPECT_TRUE(std::isfinite(saturated) && saturated >= 0.0) << "at the range " << saturated;
      const double other = any_mounting ? of(turned(swing, mounting)) : swung;
      EXPECT_NEAR(other, swung, 1e-9 * swung) << "in another mounting";
    }
  }

 private:
  using Window = std::deque<FootReading>;

  [[nodiscard]] static Eigen::Vector3d normal(Rng& rng) {
    const double x = rng.normal(), y = rng.normal();
    return {x, y, rng.normal()};
  }
  [[nodiscard]] double of(const Window& readings) const {
    return statistic(StanceWindow(readings.begin(), readings.end()));
  }
  /// Of a unit that turns at several rad/s and is accelerated by several g, times `motion`.
  [[nodiscard]] Window window(std::size_t n, double motion, const SO3d& mounting, Rng& rng) const {
    Window readings(n);
    const Eigen::Vector3d up = mounting * Eigen::Vector3d(0.0, 0.0, gravity_mps2);
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector3d a = normal(rng).normalized(), w = normal(rng).normalized();
      readings[i].time = LogTime::from_nanoseconds(5'000'000 * static_cast<std::int64_t>(i));
      readings[i].specific_force_mps2 = up + motion * 40.0 * (a + up.normalized());
      readings[i].angular_rate_radps = motion * 6.0 * w;
    }
    return readings;
  }
  [[nodiscard]] static Window turned(Window readings, const SO3d& by) {
    for (FootReading& r : readings) {
      r.specific_force_mps2 = by * r.specific_force_mps2;
      r.angular_rate_radps = by * r.angular_rate_radps;
    }
    return readings;
  }
};

}  // namespace wayfare::testing
