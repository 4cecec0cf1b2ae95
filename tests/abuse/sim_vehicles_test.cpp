// Vehicles, satellites and walkers of the simulation with inputs that are none.

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/sim/gnss.hpp>
#include <wayfare/sim/ins_monte_carlo.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>
#include <wayfare/sim/walks.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::tests {
namespace {

using namespace wayfare::sim;

const Geodetic kPlace{Angle::degrees(51.0), Angle::degrees(-114.0), 1100.0};

TEST(DriveWaypointsAbuse, WhatCannotBeDrivenIsAnErrorOfAnySize) {
  const auto drive = [](std::vector<Waypoint> points, const VehicleLimits& limits = {}) {
    return drive_waypoints(kPlace, points, limits);
  };
  EXPECT_TRUE(drive({{0, 0}, {100, 0}}));
  EXPECT_FALSE(drive({}));
  EXPECT_FALSE(drive({{0, 0}}));
  EXPECT_FALSE(drive({{0, 0}, {0, 0}}));
  for (const double odd : {kNan, kInf, -kInf, kHuge, 1e9}) {
    EXPECT_FALSE(drive({{0, 0}, {odd, 0}})) << odd;
    EXPECT_FALSE(drive({{0, 0, 0, odd}, {100, 0}})) << odd;
    EXPECT_FALSE(drive({{0, 0, odd}, {100, 0}})) << odd;
    if (!std::isfinite(odd)) {
      EXPECT_FALSE(drive_waypoints({Angle::radians(odd), Angle{}, 0.0},
                                   std::vector<Waypoint>{{0, 0}, {9, 0}}));
    }
  }
  const auto backwards = drive({{0, 0}, {50, 0, 0, -1.0}, {100, 0}});
  ASSERT_FALSE(backwards);
  EXPECT_NE(backwards.error().message.find("waypoint 1 has a negative time"), std::string::npos);
  VehicleLimits slow;
  slow.speed_mps = 1e-9;
  EXPECT_FALSE(drive({{0, 0}, {100, 0}}, slow));
}

TEST(FollowSolutionAbuse, RecordedStatesWithGapsOfYearsAreErrors) {
  std::vector<NavState> states(10);
  for (std::size_t i = 0; i < states.size(); ++i) {
    states[i].time = LogTime::from_seconds(static_cast<double>(i));
    states[i].position = kPlace;
  }
  EXPECT_TRUE(follow_solution(states));
  EXPECT_FALSE(follow_solution({}));
  EXPECT_FALSE(follow_solution(std::span(states).first(3)));
  for (const double far_s : {1e9, 9e18, -5.0}) {
    auto gap = states;
    gap.back().time = LogTime::from_seconds(far_s);
    EXPECT_FALSE(follow_solution(gap)) << far_s;
  }
  for (const double odd : kNotFinite) {
    auto bad = states;
    bad[4].position.height_m = odd;
    EXPECT_FALSE(follow_solution(bad));
    bad = states;
    bad[4].velocity_ned_mps.x() = odd;
    EXPECT_FALSE(follow_solution(bad));
  }
  for (NavState& s : states) s.time = LogTime{};
  EXPECT_FALSE(follow_solution(states));
}

TEST(VehicleAbuse, AtRestAtAnyTimeOutsideTheDrive) {
  const VehicleTrajectory drive =
      drive_waypoints(kPlace, std::vector<Waypoint>{{0, 0}, {60, 0}}).value();
  for (const std::int64_t ns :
       {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()}) {
    const VehicleMotion m = drive.motion(LogTime::from_nanoseconds(ns));
    EXPECT_LT(m.nav.velocity_ned_mps.norm(), 1e-9);
    EXPECT_TRUE(m.specific_force_mps2.allFinite());
  }
  ImuParams unit;
  unit.period = std::chrono::hours(1);
  EXPECT_EQ(simulate_imu(drive, unit, Rng(1)).samples.size(), 1U);
  unit.noise.gyro_bias_radps.tau_s.setZero();
  for (const ImuSample& s : simulate_imu(drive, unit, Rng(1)).samples)
    EXPECT_TRUE(s.angular_rate_radps.allFinite());
  EXPECT_TRUE(ins_monte_carlo(drive, Constellation{}, 0, {}, Rng(1)).empty());
  EXPECT_EQ(ins_monte_carlo(drive, Constellation{}, 1, {}, Rng(1)).size(), 1U);
}

TEST(SatellitesAbuse, UnknownSatellitesAndReceiversNowhere) {
  const Time<GpsClock> now = Time<GpsClock>::from_seconds(1e9);
  const Constellation gps = walker_constellation();
  for (const double odd : {kNan, kInf, -kInf, kHuge})
    EXPECT_FALSE(seen_from(gps, gps.satellites[0], now, {odd, 0.0, 0.0})) << odd;
  EXPECT_TRUE(seen_from(gps, gps.satellites[0], now, {1e9, 0.0, 0.0}));
  EXPECT_FALSE(seen_from(gps, {GnssSystem::beidou, 1}, now, {6e6, 0, 0}));
  EXPECT_FALSE(seen_from(gps, {GnssSystem::gps, 0}, now, {6e6, 0, 0}));
  for (const Constellation& both :
       {combined(gps, {}), combined({}, gps), combined(combined({}, {}), gps)}) {
    EXPECT_EQ(both.satellites.size(), 24U);
    EXPECT_TRUE(seen_from(both, gps.satellites[5], now, {6e6, 0, 0}));
    EXPECT_FALSE(seen_from(both, {GnssSystem::beidou, 1}, now, {6e6, 0, 0}));
  }
  Constellation lost = gps;
  lost.motion = [](SatelliteId, Time<GpsClock>) {
    return std::optional(SatelliteMotion{Eigen::Vector3d::Constant(kNan)});
  };
  EXPECT_FALSE(seen_from(lost, gps.satellites[0], now, {6e6, 0, 0}));
  const VehicleTrajectory drive =
      drive_waypoints(kPlace, std::vector<Waypoint>{{0, 0}, {60, 0}}).value();
  for (const RangeEpoch& e : simulate_ranges(drive, lost, {}, Rng(1)).epochs)
    EXPECT_TRUE(e.satellites.empty());
  EXPECT_FALSE(simulate_ranges(drive, {}, {}, Rng(1)).epochs.empty());
  EXPECT_FALSE(simulate_observations(drive, Ephemerides{}, {}, Rng(1)).epochs.empty());
  ObservationParams nowhere;
  nowhere.antenna_lever_arm_m.setConstant(kNan);
  for (const ObservationEpoch& e :
       simulate_observations(drive, walker_ephemerides({}, now), nowhere, Rng(1)).epochs)
    EXPECT_TRUE(e.satellites.empty());
}

TEST(SatellitesAbuse, GeometryOfNothing) {
  EXPECT_TRUE(best_geometry({}, 5).empty());
  EXPECT_TRUE(best_geometry({{0, 0, 1}}, 0).empty());
  const std::vector<Eigen::Vector3d> same(20, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(best_geometry(same, std::numeric_limits<std::size_t>::max()).size(), 20U);
  EXPECT_EQ(best_geometry({Eigen::Vector3d::Constant(kNan), {0, 0, 1}}, 1).size(), 1U);
  Rng rng(1);
  const ReceiverClock clock = step_clock({1.0, 2.0}, {}, 0.0, rng);
  EXPECT_EQ(clock.bias_m, 1.0);
  EXPECT_GT(satellites_allowed({}, LogTime{}), std::size_t{1} << 40);
}

TEST(SatellitesDeathTest, PlanesHaveSatellites) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  WalkerParams none;
  none.planes = 0;
  EXPECT_DEATH((void)walker_constellation(none), "plane");
  EXPECT_DEATH((void)walker_ephemerides(none, {}), "plane");
}

TEST(WalksAbuse, WaypointsGivenTwiceAreOne) {
  using Route = std::vector<Eigen::Vector2d>;
  const HeadWalk once(Route{{0, 0}, {5, 0}}, {}, Rng(1));
  const HeadWalk twice(Route{{0, 0}, {0, 0}, {5, 0}, {5, 0}, {5, 0}}, {}, Rng(1));
  EXPECT_EQ(once.duration_s(), twice.duration_s());
  for (const double t : {-1e9, 0.0, 1.0, 6.0, once.duration_s(), 1e9}) {
    EXPECT_EQ(once.at(t).position_m, twice.at(t).position_m) << t;
    EXPECT_TRUE(twice.at(t).position_m.allFinite()) << t;
    EXPECT_NEAR(twice.at(t).q_world_head.quaternion().norm(), 1.0, 1e-9) << t;
  }
}

TEST(WalksDeathTest, NeedARouteAndAFiniteNumberOfSamples) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  using Route = std::vector<Eigen::Vector2d>;
  EXPECT_DEATH(HeadWalk(Route{}, {}, Rng(1)), "waypoints");
  EXPECT_DEATH(HeadWalk(Route{{1, 1}, {1, 1}}, {}, Rng(1)), "waypoints");
  EXPECT_DEATH(HeadWalk(Route{{1, 1}, {kNan, 1}}, {}, Rng(1)), "waypoints");
  Rng rng(1);
  const HeadWalk walk(Route{{0, 0}, {5, 0}}, {}, Rng(1));
  EXPECT_DEATH((void)walk.unit(1e9, {}, rng), "samples");
  FeetPlan feet;
  feet.strides = 1'000'000'000;
  EXPECT_DEATH((void)simulate_feet(feet, perfect_imu(), rng), "samples");
  feet = {};
  feet.stance_s = kNan;
  EXPECT_DEATH((void)simulate_feet(feet, perfect_imu(), rng), "samples");
}

TEST(WalksAbuse, AHeadThatIsNowhereSeesNothing) {
  const FloorPlan plan = FloorPlan::from_segments({{{-3, -3}, {3, -3}}}).value();
  Rng rng(1);
  HeadWalk::Pose head{SO3d(), Eigen::Vector3d(kNan, 0.0, 1.7)};
  for (const float r : scan_from_head(plan, head, LogTime{}, {}, rng).ranges_m)
    EXPECT_TRUE(std::isnan(r));
  HeadLidarParams none;
  none.beams = 0;
  EXPECT_TRUE(scan_from_head(plan, head, LogTime{}, none, rng).ranges_m.empty());
}

TEST(SimVehiclesAbuse, TwoThreadsDriveTheSame) {
  const auto both = in_two_threads([](int) {
    const VehicleTrajectory drive =
        drive_waypoints(kPlace, std::vector<Waypoint>{{0, 0}, {60, 0}, {60, 60}}).value();
    std::vector<double> all;
    for (const ImuSample& s : simulate_imu(drive, {}, Rng(2)).samples)
      all.push_back(s.angular_rate_radps.z());
    for (const RangeEpoch& e : simulate_ranges(drive, gps_and_galileo(), {}, Rng(3)).epochs)
      for (const CorrectedRange& r : e.satellites) all.push_back(r.range_m);
    return all;
  });
  EXPECT_EQ(both[0], both[1]);
}

}  // namespace
}  // namespace wayfare::tests
