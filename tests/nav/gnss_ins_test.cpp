#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gnss_ins_support.hpp"

namespace wayfare {
namespace {

using namespace tests;

GnssInsStart start_at(const NavState& nav) { return {nav, 1.0, 0.1, 0.01, 0.05}; }

// An exact unit without roll and pitch: 60 s without GNSS leave only the integration error at 100
// Hz.
TEST(GnssIns, IntegratesExactReadings) {
  const Drive drive;
  const Simulated s = simulate(drive, 60.0);
  GnssInsRecording recording{s.imu, {}, {}, start_at(s.truth.front())};
  GnssInsOptions options;
  options.non_holonomic_in_outage = options.zero_velocity_updates = false;
  const auto result = run_gnss_ins(recording, options);
  ASSERT_TRUE(result) << result.error().to_string();
  EXPECT_LT(distance_m(result->points.back().nav, s.truth.back()), 0.02);
  EXPECT_LT(result->points.back().nav.q_nb.minus(s.truth.back().q_nb).norm(), 1e-5);
}

TEST(GnssIns, InitialisesItselfAndFollowsRanges) {
  const Drive drive;
  const Simulated s = simulate(drive, 60.0);
  const Eigen::Vector3d lever(0.5, -0.3, -1.2);
  GnssInsRecording recording{s.imu, simulate_ranges(drive, s, 0.5, {}, 1, 8, lever), {}, {}};
  GnssInsOptions options;
  options.antenna_lever_arm_m = lever;
  const auto result = run_gnss_ins(recording, options);
  ASSERT_TRUE(result) << result.error().to_string();
  EXPECT_LT(distance_m(result->points.back().nav, s.truth.back()), 2.0);
  EXPECT_LT(result->points.back().nav.q_nb.minus(s.truth.back().q_nb).norm(), 0.02);
  EXPECT_NEAR(result->points.back().clock_drift_mps, 5.0, 0.2);
}

}  // namespace
}  // namespace wayfare
