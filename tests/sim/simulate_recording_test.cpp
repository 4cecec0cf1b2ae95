#include <wayfare/sim/simulate_recording.hpp>

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support.hpp"

namespace wayfare::sim {
namespace {

using ::testing::HasSubstr;

PlannedRoute office() { return planned(kOffice); }

RobotParams robot() {
  RobotParams params;
  params.lidar = full_circle(90);
  params.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(0.1, 0.0, Angle{}));
  return params;
}

bool same_scans(const Recording& a, const Recording& b) {
  if (a.scans.size() != b.scans.size()) return false;
  for (std::size_t i = 0; i < a.scans.size(); ++i) {
    if (a.scans[i].time != b.scans[i].time || a.scans[i].ranges_m != b.scans[i].ranges_m)
      return false;
  }
  return true;
}

bool same_odometry(const Recording& a, const Recording& b) {
  if (a.odometry.size() != b.odometry.size()) return false;
  for (std::size_t i = 0; i < a.odometry.size(); ++i) {
    const SE2d &p = a.odometry[i].T_odom_base.raw(), &q = b.odometry[i].T_odom_base.raw();
    if (p.translation() != q.translation() || p.rotation().sin() != q.rotation().sin())
      return false;
  }
  return true;
}

TEST(SimulateRecording, IsDeterminedByTheSeed) {
  const PlannedRoute o = office();
  const auto a = simulate_recording(o.plan, o.route_m, robot(), Rng(4));
  const auto b = simulate_recording(o.plan, o.route_m, robot(), Rng(4));
  const auto c = simulate_recording(o.plan, o.route_m, robot(), Rng(5));
  ASSERT_TRUE(a && b && c);
  EXPECT_TRUE(same_scans(a->recording, b->recording));
  EXPECT_TRUE(same_odometry(a->recording, b->recording));
  EXPECT_FALSE(same_scans(a->recording, c->recording));
  EXPECT_FALSE(same_odometry(a->recording, c->recording));
}

TEST(SimulateRecording, ChangingOneSensorDoesNotChangeTheOthers) {
  const PlannedRoute o = office();
  RobotParams worse_wheels = robot();
  worse_wheels.wheels.slip_m_per_sqrt_m *= 2;
  const auto a = simulate_recording(o.plan, o.route_m, robot(), Rng(4));
  const auto b = simulate_recording(o.plan, o.route_m, worse_wheels, Rng(4));
  ASSERT_TRUE(a && b);
  EXPECT_TRUE(same_scans(a->recording, b->recording));
  EXPECT_FALSE(same_odometry(a->recording, b->recording));
}

TEST(SimulateRecording, ScansAreFromTheTruePose) {
  const PlannedRoute o = office();
  RobotParams params = robot();
  params.lidar.range_noise_m = params.lidar.resolution_m = params.lidar.missed_return = 0.0;
  const auto run = simulate_recording(o.plan, o.route_m, params, Rng(4));
  ASSERT_TRUE(run.has_value());
  ASSERT_GT(run->recording.scans.size(), 20U);
  for (const LaserScan& scan : run->recording.scans) {
    const SE2d pose = true_pose_at(run->truth, scan.time) * params.T_base_laser.raw();
    for (std::size_t i = 0; i < scan.ranges_m.size(); i += 7) {
      const double b = scan.bearing(i).radians(), r = static_cast<double>(scan.ranges_m[i]);
      const Eigen::Vector2d end = pose * Eigen::Vector2d(r * std::cos(b), r * std::sin(b));
      EXPECT_LT(o.plan.clearance(end, 1.0), 1e-5);
    }
  }
}

TEST(SimulateRecording, TimesAreInOrderAndCoverTheRun) {
  const PlannedRoute o = office();
  const auto run = simulate_recording(o.plan, o.route_m, robot(), Rng(4));
  ASSERT_TRUE(run.has_value());
  const auto& scans = run->recording.scans;
  for (std::size_t i = 1; i < scans.size(); ++i)
    EXPECT_EQ(scans[i].time - scans[i - 1].time, robot().scan_period);
  EXPECT_LT(run->truth.back().time - scans.back().time, robot().scan_period);
  EXPECT_EQ(run->recording.odometry.size(), run->wheels.size());
  EXPECT_EQ(run->recording.odometry.front().time, run->truth.front().time);
}

TEST(SimulateRecording, ReportsAWallOnTheRoute) {
  const PlannedRoute o = office();
  const std::vector<Eigen::Vector2d> through = {{1.0, 3.3}, {8.0, 3.3}};
  const auto run = simulate_recording(o.plan, through, robot(), Rng(1));
  ASSERT_FALSE(run.has_value());
  EXPECT_THAT(run.error().message, HasSubstr("between waypoint 0"));
}

TEST(SimulateRecording, ReportsThePositionOfAContact) {
  const PlannedRoute o = office();
  const std::vector<Eigen::Vector2d> close = {{1.0, 2.0}, {1.0, 0.6}, {1.0, 0.51}};
  RobotParams params = robot();
  params.drive.waypoint_radius_m = 0.05;
  const auto run = simulate_recording(o.plan, close, params, Rng(1));
  ASSERT_FALSE(run.has_value());
  EXPECT_THAT(run.error().message, HasSubstr("touch a wall at (1.00, 0.7"));
}

TEST(SimulateRecording, RefusesAnOpenPlan) {
  const auto open = FloorPlan::from_segments({{{0, 0}, {5, 0}}, {{0, 3}, {5, 3}}}).value();
  const std::vector<Eigen::Vector2d> route = {{1, 1.5}, {4, 1.5}};
  const auto run = simulate_recording(open, route, robot(), Rng(1));
  ASSERT_FALSE(run.has_value());
  EXPECT_THAT(run.error().message, HasSubstr("not closed"));
}

TEST(SimulateRecording, ReportsProgressAndStopsOnRequest) {
  const PlannedRoute o = office();
  std::stop_source source;
  double last = -1.0;
  SimulationControl control;
  control.stop = source.get_token();
  control.progress = [&](double fraction) {
    EXPECT_GT(fraction, last);
    EXPECT_LE(fraction, 1.0);
    last = fraction;
    if (fraction > 0.5) source.request_stop();
  };
  const auto run = simulate_recording(o.plan, o.route_m, robot(), Rng(1), control);
  ASSERT_FALSE(run.has_value());
  EXPECT_EQ(run.error().code, ErrorCode::cancelled);
}

TEST(SimulateRecording, TheDemoBuildingCanBeDriven) {
  const auto demo = read_plan(demo_building());
  ASSERT_TRUE(demo.has_value());
  RobotParams params;
  params.scan_period = from_seconds(5.0);  // this test is for the drive
  const auto run = simulate_recording(demo->plan, demo->route_m, params, Rng(1));
  ASSERT_TRUE(run.has_value()) << run.error().to_string();
}

}  // namespace
}  // namespace wayfare::sim
