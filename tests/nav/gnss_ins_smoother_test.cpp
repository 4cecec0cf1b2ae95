// Smoothing of inertial navigation: against the filter, by its own consistency, and the same over
// a lag and over a whole recording.

#include <algorithm>
#include <cmath>
#include <limits>
#include <stop_token>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/nav/outage.hpp>

#include "nav/gnss_ins_support.hpp"

namespace wayfare::tests {
namespace {

/// Readings with the noise of the default unit and its biases times a factor, and ranges of 2 m
/// once a second.
struct Noisy {
  explicit Noisy(std::uint64_t seed, double length_s = 100.0, double noise_factor = 1.0) {
    const Drive drive;
    const Simulated s = simulate(drive, length_s);
    truth = s.truth;
    recording.imu = s.imu;
    recording.ranges = simulate_ranges(drive, s, 1.0, RangeErrors{}, seed);
    options.imu.accel_bias_mps2.sigma *= noise_factor;
    options.imu.gyro_bias_radps.sigma *= noise_factor;
    const ImuNoise noise = options.imu;
    Rng rng(seed + 1000);
    const auto draw = [&rng](const Eigen::Vector3d& sigma) {
      return Eigen::Vector3d(sigma.x() * rng.normal(), sigma.y() * rng.normal(),
                             sigma.z() * rng.normal());
    };
    const Eigen::Vector3d gyro_bias = draw(noise.gyro_bias_radps.sigma);
    const Eigen::Vector3d accel_bias = draw(noise.accel_bias_mps2.sigma);
    for (ImuSample& i : recording.imu) {
      i.angular_rate_radps += gyro_bias + draw(noise.gyro_white_rad_per_sqrt_s / std::sqrt(0.01));
      i.specific_force_mps2 +=
          accel_bias + draw(noise.accel_white_mps_per_sqrt_s / std::sqrt(0.01));
    }
    options.non_holonomic_in_outage = false;
    GnssInsStart around;
    around.nav = truth.front();
    recording.start = drawn_start(truth.front(), around, rng);
  }

  /// Largest horizontal error within a window.
  [[nodiscard]] double worst(const GnssInsResult& r, const OutageWindow& window) const {
    double worst_m = 0.0;
    auto at = truth.begin();
    for (const GnssInsPoint& p : r.points) {
      if (!window.contains(p.nav.time)) continue;
      while (at != truth.end() && at->time < p.nav.time) ++at;
      worst_m = std::max(worst_m, ned_from_geodetic(p.nav.position, at->position).head<2>().norm());
    }
    return worst_m;
  }

  GnssInsOptions options;
  GnssInsRecording recording;
  NavTrajectory truth;
};

TEST(GnssInsSmoother, EndsWhereTheFilterEnds) {
  const Noisy drive(1, 30.0);
  const auto filtered = run_gnss_ins(drive.recording, drive.options);
  const auto smoothed = smooth_gnss_ins(drive.recording, drive.options);
  ASSERT_TRUE(filtered && smoothed);
  ASSERT_EQ(smoothed->points.size(), filtered->points.size());
  EXPECT_EQ(smoothed->innovations.size(), filtered->innovations.size());
  EXPECT_EQ(smoothed->notices.size(), filtered->notices.size());
  for (std::size_t i = 0; i < filtered->points.size(); ++i) {
    ASSERT_EQ(smoothed->points[i].nav.time, filtered->points[i].nav.time);
    // More measurements never make it less certain, by how the covariance is rounded to float.
    ASSERT_TRUE(
        (smoothed->points[i].sigma.array() <= 1.001F * filtered->points[i].sigma.array()).all())
        << i;
  }
  EXPECT_EQ(distance_m(smoothed->points.back().nav, filtered->points.back().nav), 0.0);
  EXPECT_EQ(smoothed->points.back().sigma, filtered->points.back().sigma);
}

TEST(GnssInsSmoother, BridgesAnOutageFromBothSides) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    Noisy drive(seed, 100.0, 10.0);
    const OutageWindow window{LogTime::from_seconds(40.0), LogTime::from_seconds(70.0), 0};
    apply_outage(window, drive.recording);
    const auto filtered = run_gnss_ins(drive.recording, drive.options);
    const auto smoothed = smooth_gnss_ins(drive.recording, drive.options);
    ASSERT_TRUE(filtered && smoothed);
    EXPECT_LT(drive.worst(*smoothed, window), 0.4 * drive.worst(*filtered, window)) << seed;
    // Its own standard deviation is largest within, and holds the error.
    for (const GnssInsPoint& p : smoothed->points) {
      const auto i = static_cast<std::size_t>(std::lround(p.nav.time.seconds() / 0.01));
      const Eigen::Vector3d error = ned_from_geodetic(p.nav.position, drive.truth[i].position);
      EXPECT_LT((error.array() / p.sigma.head<3>().cast<double>().array()).abs().maxCoeff(), 5.0)
          << seed << ", " << p.nav.time.seconds() << " s";
    }
  }
}

/// The estimate at the end of a filter with a lag, which got its epochs `epochs_late_s` late.
std::optional<GnssInsEstimate> lagged_by(const Noisy& drive, double lag_s, double epochs_late_s) {
  GnssInsOptions options = drive.options;
  options.smoothing_lag_s = lag_s;
  GnssIns filter(options);
  filter.start(*drive.recording.start);
  std::size_t k = 0;
  for (const ImuSample& s : drive.recording.imu) {
    EXPECT_TRUE(filter.add(s));
    for (; k < drive.recording.ranges.size() &&
           drive.recording.ranges[k].time + from_seconds(epochs_late_s) <= s.time;
         ++k)
      EXPECT_TRUE(filter.add(drive.recording.ranges[k]));
  }
  for (; k < drive.recording.ranges.size(); ++k)
    EXPECT_TRUE(filter.add(drive.recording.ranges[k]));
  return filter.lagged();
}

TEST(GnssInsSmoother, CorrelatedErrorsAreNotSmoothed) {
  Noisy drive(4, 40.0);
  ASSERT_TRUE(lagged_by(drive, 4.5, 0.0));
  drive.options.correlated.share = 0.5;
  EXPECT_FALSE(lagged_by(drive, 4.5, 0.0));
  EXPECT_FALSE(smooth_gnss_ins(drive.recording, drive.options));
}

TEST(GnssInsSmoother, ALagIsTheEndOfTheWhole) {
  const Noisy drive(4, 40.0);
  const auto whole = smooth_gnss_ins(drive.recording, drive.options);
  ASSERT_TRUE(whole);
  for (const double lag_s : {0.5, 4.5, 19.5}) {
    const auto lagged = lagged_by(drive, lag_s, 0.0);
    ASSERT_TRUE(lagged) << lag_s;
    const auto same =
        std::find_if(whole->points.begin(), whole->points.end(),
                     [&](const GnssInsPoint& p) { return p.nav.time == lagged->nav.time; });
    ASSERT_NE(same, whole->points.end());
    EXPECT_NEAR(to_seconds(whole->points.back().nav.time - lagged->nav.time), lag_s, 0.011);
    EXPECT_LT(distance_m(lagged->nav, same->nav), 1e-6) << lag_s;
    EXPECT_LT(lagged->nav.q_nb.minus(same->nav.q_nb).norm(), 1e-9) << lag_s;
  }
}

TEST(GnssInsSmoother, LateMeasurementsCountAsIfInTime) {
  const Noisy drive(5, 30.0);
  const auto in_time = lagged_by(drive, 6.0, 0.0);
  const auto late = lagged_by(drive, 6.0, 0.37);
  ASSERT_TRUE(in_time && late);
  EXPECT_EQ(late->nav.time, in_time->nav.time);
  EXPECT_LT(distance_m(late->nav, in_time->nav), 1e-6);
}

TEST(GnssInsSmoother, NothingIsLaggedBeforeItsTime) {
  const Noisy drive(6, 4.0);
  EXPECT_FALSE(lagged_by(drive, 5.0, 0.0));
  EXPECT_FALSE(lagged_by(drive, 0.0, 0.0)) << "no lag was asked for";
}

TEST(GnssInsSmoother, WhatComesAfterANewStartSaysNothingOfBefore) {
  Noisy drive(7, 60.0);
  const auto gap = [](const ImuSample& s) {
    return s.time > LogTime::from_seconds(25.0) && s.time < LogTime::from_seconds(36.5);
  };
  std::erase_if(drive.recording.imu, gap);
  std::erase_if(drive.recording.ranges, [](const RangeEpoch& e) {
    return e.time > LogTime::from_seconds(25.0) && e.time < LogTime::from_seconds(36.5);
  });
  const auto whole = smooth_gnss_ins(drive.recording, drive.options);
  std::erase_if(drive.recording.imu,
                [](const ImuSample& s) { return s.time > LogTime::from_seconds(30.0); });
  std::erase_if(drive.recording.ranges,
                [](const RangeEpoch& e) { return e.time > LogTime::from_seconds(30.0); });
  const auto first = smooth_gnss_ins(drive.recording, drive.options);
  ASSERT_TRUE(whole && first);
  ASSERT_LT(first->points.size(), whole->points.size());
  for (std::size_t i = 0; i < first->points.size(); ++i)
    ASSERT_EQ(distance_m(first->points[i].nav, whole->points[i].nav), 0.0) << i;
}

TEST(GnssInsSmoother, ACopyContinuesByItself) {
  const Noisy drive(8, 20.0);
  GnssIns filter(drive.options);
  filter.start(*drive.recording.start);
  for (std::size_t i = 0; i < 500; ++i) ASSERT_TRUE(filter.add(drive.recording.imu[i]));
  GnssIns copy = filter;
  const GnssInsPoint before = filter.point();
  for (std::size_t i = 500; i < 900; ++i) ASSERT_TRUE(copy.add(drive.recording.imu[i]));
  EXPECT_EQ(distance_m(filter.point().nav, before.nav), 0.0);
  for (std::size_t i = 500; i < 900; ++i) ASSERT_TRUE(filter.add(drive.recording.imu[i]));
  EXPECT_EQ(distance_m(filter.point().nav, copy.point().nav), 0.0);
}

TEST(GnssInsSmoother, RefusesWhatTheFilterRefuses) {
  const Noisy drive(9, 5.0);
  EXPECT_EQ(smooth_gnss_ins({}, drive.options).error().code, ErrorCode::invalid);
  GnssInsRecording no_start = drive.recording;
  no_start.start.reset();
  EXPECT_EQ(smooth_gnss_ins(no_start, drive.options).error().code, ErrorCode::degenerate);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(smooth_gnss_ins(drive.recording, drive.options, {}, stop.get_token()).error().code,
            ErrorCode::cancelled);
}

TEST(GnssInsSmoother, OrderOfTheRecordingDoesNotMatter) {
  const Noisy drive(10, 10.0);
  GnssInsRecording shuffled = drive.recording;
  std::reverse(shuffled.ranges.begin(), shuffled.ranges.end());
  const auto expected = smooth_gnss_ins(drive.recording, drive.options);
  const auto found = smooth_gnss_ins(shuffled, drive.options);
  ASSERT_TRUE(expected && found);
  ASSERT_EQ(found->points.size(), expected->points.size());
  EXPECT_EQ(distance_m(found->points.front().nav, expected->points.front().nav), 0.0);
}

}  // namespace
}  // namespace wayfare::tests
