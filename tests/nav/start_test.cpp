// Starts of the filter from what there is: at rest, by positions alone, from a given state.

#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gnss_ins_support.hpp"

namespace wayfare {
namespace {

using namespace tests;

constexpr Eigen::Index kYaw = ins_state::kAttitude + 2;

GnssInsRecording recorded(const Drive& drive, const Simulated& s, std::uint64_t seed) {
  return {s.imu, simulate_ranges(drive, s, 1.0, {}, seed), {}, {}};
}

GnssInsRecording without_rates(GnssInsRecording r) {
  for (RangeEpoch& e : r.ranges)
    for (CorrectedRange& s : e.satellites)
      s.range_rate_mps = std::numeric_limits<double>::quiet_NaN();
  return r;
}

/// Within three σ, of the heading too.
void expect_consistent(const GnssInsPoint& p, const NavState& truth) {
  const Eigen::Vector3d error = ned_from_geodetic(p.nav.position, truth.position);
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(error[i]), 3.5 * p.sigma[i]) << "axis " << i;
  const double yaw = (p.nav.q_nb * truth.q_nb.inverse()).log().z();
  EXPECT_LT(std::abs(yaw), 3.5 * p.sigma[kYaw]);
}

TEST(GnssInsStart, AtRestTheHeadingStaysUnknown) {
  Drive drive;
  drive.rest_s = 1e9;
  const Simulated s = simulate(drive, 60.0, 0.02);
  for (const auto& r : {recorded(drive, s, 1), without_rates(recorded(drive, s, 2))}) {
    const auto result = run_gnss_ins(r, {});
    ASSERT_TRUE(result) << result.error().to_string();
    const GnssInsPoint& last = result->points.back();
    EXPECT_GT(last.sigma[kYaw], 1.5);
    expect_consistent(last, s.truth.back());
    EXPECT_LT(distance_m(last.nav, s.truth.back()), 3.0);
    EXPECT_LT(last.nav.velocity_ned_mps.norm(), 0.1);
    const Eigen::Vector3d level = roll_pitch_yaw_rad(last.nav.q_nb);
    EXPECT_LT(level.head<2>().norm(), 0.02);
  }
}

TEST(GnssInsStart, MotionGivesTheHeadingAfterRest) {
  Drive drive;
  drive.rest_s = 30.0;
  const Simulated s = simulate(drive, 90.0, 0.02);
  GnssInsOptions options;
  options.start_without_velocity = true;
  const auto result = run_gnss_ins(recorded(drive, s, 3), options);
  ASSERT_TRUE(result) << result.error().to_string();
  EXPECT_LT(result->points.front().nav.time.seconds(), 15.0);
  bool known = false;
  for (std::size_t i = 0; i < result->points.size(); i += 10) {
    const GnssInsPoint& p = result->points[i];
    known = known || p.sigma[kYaw] < 0.5F;
    EXPECT_EQ(p.sigma[kYaw] < 0.5F, known) << "the heading was lost";
    if (p.nav.time.seconds() < 29.0) {
      EXPECT_FALSE(known);
    }
  }
  expect_consistent(result->points.back(), s.truth.back());
  EXPECT_LT(result->points.back().sigma[kYaw], 0.1F);
}

TEST(GnssInsStart, PositionsAloneGiveTheHeadingOnAStraight) {
  Drive drive;
  drive.swing_rad = 0.1;
  const Simulated s = simulate(drive, 120.0, 0.02);
  GnssInsRecording r = without_rates(recorded(drive, s, 4));
  // In motion from its first reading.
  std::erase_if(r.imu, [](const ImuSample& i) { return i.time < LogTime::from_seconds(20.0); });
  std::erase_if(r.ranges, [](const RangeEpoch& e) { return e.time < LogTime::from_seconds(20.0); });
  const auto result = run_gnss_ins(r, {});
  ASSERT_TRUE(result) << result.error().to_string();
  expect_consistent(result->points.back(), s.truth.back());
  EXPECT_LT(result->points.back().sigma[kYaw], 0.2F);
}

TEST(GnssInsStart, FixesWithoutVelocityAreEnough) {
  const Drive drive;
  const Simulated s = simulate(drive, 90.0, 0.02);
  GnssInsRecording r{s.imu, {}, {}, {}};
  Rng rng(5);
  for (std::size_t i = 0; i < s.truth.size(); i += 50) {
    GnssFix fix;
    fix.time = s.truth[i].time;
    const Eigen::Vector3d noise(rng.normal(0.0, 0.5), rng.normal(0.0, 0.5), rng.normal(0.0, 0.5));
    fix.position = geodetic_from_ned(noise, s.truth[i].position);
    fix.position_covariance_ned_m2 *= 0.25;
    r.fixes.push_back(fix);
  }
  const auto result = run_gnss_ins(r, {});
  ASSERT_TRUE(result) << result.error().to_string();
  expect_consistent(result->points.back(), s.truth.back());
  EXPECT_LT(result->points.back().sigma[kYaw], 0.1F);
}

TEST(GnssInsStart, AGivenStartMayHaveAnUnknownHeading) {
  const Drive drive;
  const Simulated s = simulate(drive, 60.0, 0.02);
  GnssInsRecording r = recorded(drive, s, 6);
  r.start = GnssInsStart{s.truth.front()};
  r.start->nav.q_nb = SO3d::exp(2.5 * Eigen::Vector3d::UnitZ()) * r.start->nav.q_nb;
  r.start->heading_sigma_rad = 3.0;
  const auto result = run_gnss_ins(r, {});
  ASSERT_TRUE(result) << result.error().to_string();
  EXPECT_EQ(result->points.front().nav.time, r.imu[0].time);
  EXPECT_GT(result->points[10].sigma[kYaw], 1.5);
  expect_consistent(result->points.back(), s.truth.back());
  EXPECT_LT(result->points.back().sigma[kYaw], 0.1F);
}

TEST(GnssInsStart, TheErrorSaysWhatIsMissing) {
  const Drive drive;
  const Simulated s = simulate(drive, 12.0, 0.02);
  const auto message = [](const GnssInsRecording& r) {
    const auto result = run_gnss_ins(r, {});
    return result ? std::string("started") : result.error().message;
  };
  const GnssInsRecording good = recorded(drive, s, 7);
  GnssInsRecording r = good;
  for (RangeEpoch& e : r.ranges) e.satellites.resize(3);
  EXPECT_THAT(message(r), ::testing::HasSubstr("at least four satellites"));
  // Turns all the time: no straight, no rest.
  r = without_rates(good);
  for (ImuSample& i : r.imu) i.angular_rate_radps.z() += 1.0;
  EXPECT_THAT(message(r), ::testing::HasSubstr("no Doppler"));
  r = good;
  for (ImuSample& i : r.imu) i.time += std::chrono::seconds(1000);
  EXPECT_THAT(message(r), ::testing::HasSubstr("imu_time_offset_s"));
  r = good;
  r.ranges.resize(6);  // the vehicle has just moved off
  EXPECT_THAT(message(r), ::testing::HasSubstr("start_speed_mps"));
  GnssIns filter{GnssInsOptions{}};
  EXPECT_THAT(filter.missing(), ::testing::HasSubstr("no usable inertial readings"));
}

}  // namespace
}  // namespace wayfare
