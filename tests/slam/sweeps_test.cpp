// Scans whose beams are measured one after the other, given to the systems.

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/walks.hpp>
#include <wayfare/slam/graph_slam.hpp>
#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/localisation.hpp>
#include <wayfare/slam/pedestrian_slam.hpp>
#include <wayfare/slam/radar_slam.hpp>
#include <wayfare/slam/run_localisation.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "sim/support.hpp"
#include "support.hpp"

namespace wayfare {
namespace {

constexpr double kPeriod_s = 1.0 / 5.5;

/// A drive at 1 m/s and 90°/s through the office with an RPLIDAR; `sweep_s` = 0: instantaneous.
sim::SimulatedRun drive(double sweep_s) {
  sim::RobotParams robot = slipping_robot();
  robot.drive.max_speed_m_s = 1.0;
  robot.drive.max_turn_rate_rad_s = Angle::degrees(90).radians();
  robot.drive.max_acceleration_m_s2 = 1.0;
  robot.lidar = sim::full_circle(360);
  robot.lidar.max_range_m = 12.0;
  robot.lidar.sweep = from_seconds(sweep_s);
  robot.odometry_period = Duration(50'000'000);
  robot.scan_period = from_seconds(kPeriod_s);
  sim::SimulatedRun run = simulate(office_plan("a b c b a"), robot, 1);
  run.recording.gyro = run.gyro;
  run.recording.wheels = run.wheels;
  run.recording.wheel_base_m = robot.wheels.wheel_base_m;
  return run;
}

Recording without_times(Recording recording) {
  for (LaserScan& scan : recording.scans) scan.time_increment = Duration::zero();
  return recording;
}

Recording by_gyro(Recording recording) {
  recording.odometry.clear();
  return recording;
}

using Run = std::function<Result<Trajectory>(const Recording&)>;

template <class R>
Result<Trajectory> trajectory_of(const Result<R>& run) {
  return run ? Result<Trajectory>(run->trajectory) : run.error();
}

/// Instantaneous, as they are, undone.
struct Errors {
  double instant_m, as_they_are_m, undone_m;
};

Errors errors_of(const Run& run) {
  static const sim::SimulatedRun instant = drive(0.0), sweeps = drive(kPeriod_s * 359 / 360);
  const auto error = [&](const Recording& recording, const Trajectory& truth) {
    const auto found = run(recording);
    EXPECT_TRUE(found) << found.error().message;
    return rmse_m(*found, truth);
  };
  return {error(instant.recording, instant.truth),
          error(without_times(sweeps.recording), sweeps.truth),
          error(sweeps.recording, sweeps.truth)};
}

// Errors of centimetres differ between drives by their noise: 1.3 times and 5 mm. The sweeps as
// they are bend the walls by up to 8°.
void expect_undone(const Errors& errors) {
  EXPECT_LT(errors.undone_m, 1.3 * errors.instant_m + 0.005);
  EXPECT_GT(errors.as_they_are_m, errors.undone_m);
}

TEST(Sweeps, OfGraphSlamAreUndone) {
  expect_undone(errors_of([](const Recording& r) { return trajectory_of(run_graph_slam(r)); }));
}

TEST(Sweeps, OfSubmapSlamAreUndone) {
  expect_undone(errors_of([](const Recording& r) { return trajectory_of(run_submap_slam(r)); }));
  expect_undone(
      errors_of([](const Recording& r) { return trajectory_of(run_submap_slam(by_gyro(r))); }));
}

TEST(Sweeps, OfHectorSlamAreUndone) {
  expect_undone(errors_of([](const Recording& r) { return trajectory_of(run_hector_slam(r)); }));
}

TEST(Sweeps, OfTheParticleFilterAreUndone) {
  RadarSlamOptions options;
  options.particles = 10;
  expect_undone(errors_of([&](const Recording& r) {
    return trajectory_of(run_radar_slam(r, options, SlamSensors::lidar));
  }));
}

TEST(Sweeps, OfLocalisationAreUndone) {
  const sim::PlannedRoute planned_route = planned(office_plan("a b c b a"));
  const auto grid = sim::map_of_plan(planned_route.plan, planned_route.route_m.front());
  ASSERT_TRUE(grid);
  const auto map = LocalisationMap::make(*grid);
  ASSERT_TRUE(map);
  const SE2d start = drive(0.0).truth.front().T_map_base.raw();
  for (const ScanLikelihood model : {ScanLikelihood::likelihood_field, ScanLikelihood::beam})
    expect_undone(errors_of([&](const Recording& r) -> Result<Trajectory> {
      LocalisationOptions options;
      options.model = model;
      const Gaussian<SE2d> near{start, 0.01 * Eigen::Matrix3d::Identity()};
      const auto run = run_localisation(r, *map, options, 1, near);
      return run ? Result<Trajectory>(run->trajectory()) : run.error();
    }));
}

TEST(Sweeps, ThatTakeTooLongAreRefused) {
  Recording recording = drive(kPeriod_s * 359 / 360).recording;
  recording.scans.resize(5);
  recording.scans[2].time_increment = from_seconds(1.0);
  const auto run = run_graph_slam(recording);
  ASSERT_TRUE(run);
  EXPECT_EQ(run->refused_scans, 1U);
  EXPECT_THAT(run->first_refusal, ::testing::HasSubstr("scan 2: the sweep takes 359"));
}

/// A walk from one room of the office to the other and back.
struct Walked {
  Recording recording;
  MargRecording unit;
  Trajectory truth;
};

Walked walk(bool sweeps) {
  sim::PlannedRoute planned_route = planned(kOffice);
  planned_route.route_m.push_back(planned_route.route_m.front());
  Rng rng(2);
  const sim::HeadWalk head(planned_route.route_m, {}, rng.stream(1));
  Walked walked;
  walked.unit = head.unit(100.0, {}, rng);
  sim::HeadLidarParams lidar;
  if (sweeps) lidar.sweep = from_seconds(kPeriod_s * 359 / 360);
  for (double t = 1.0; t < head.duration_s() - 0.1; t += kPeriod_s)
    walked.recording.scans.push_back(
        sim::sweep_from_head(planned_route.plan, head, LogTime::from_seconds(t), lidar, rng));
  for (double t = 0.9; t < head.duration_s(); t += 0.01) {
    const Eigen::Vector2d p = head.at(t).position_m.head<2>();
    walked.truth.push_back({LogTime::from_seconds(t),
                            Transform2<frame::Map, frame::Base>(SE2d(p.x(), p.y(), Angle()))});
  }
  return walked;
}

Errors walking_errors(
    const std::function<Result<Trajectory>(const Recording&, const MargRecording&)>& run) {
  static const Walked instant = walk(false), sweeps = walk(true);
  const auto error = [&](const Recording& recording, const Walked& walked) {
    const auto found = run(recording, walked.unit);
    EXPECT_TRUE(found) << found.error().message;
    return rmse_m(*found, walked.truth);
  };
  return {error(instant.recording, instant), error(without_times(sweeps.recording), sweeps),
          error(sweeps.recording, sweeps)};
}

TEST(Sweeps, OfAWalkerAreUndone) {
  PedestrianSlamOptions options;
  options.pedestrian.forward = Eigen::Vector3d::UnitX();
  options.pedestrian.length = ConstantStep{0.66};
  options.pedestrian.ahrs.use_magnetometer = false;
  expect_undone(
      walking_errors([&](const Recording& r, const MargRecording& unit) -> Result<Trajectory> {
        const auto slam = run_pedestrian_slam(r, unit, options);
        return slam ? Result<Trajectory>(slam->slam.trajectory) : slam.error();
      }));
}

TEST(Sweeps, OfHectorSlamWithAUnitAreUndone) {
  expect_undone(walking_errors([](const Recording& r, const MargRecording& unit) {
    return trajectory_of(run_hector_slam(r, unit));
  }));
}

}  // namespace
}  // namespace wayfare
