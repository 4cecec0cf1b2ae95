#include <wayfare/slam/pedestrian_slam.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/pedestrian/walk_feedback.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/sim/walks.hpp>

#include "sim/support.hpp"

namespace wayfare {
namespace {

/// Two rooms, from one to the other and back: 22 m.
struct Walked {
  MargRecording unit;
  std::vector<LaserScan> scans;
  std::vector<Eigen::Vector2d> truth_m;
};

Walked walk_through_the_office(std::uint64_t seed) {
  const sim::PlannedRoute planned_route = planned(kOffice);
  std::vector<Eigen::Vector2d> route = planned_route.route_m;
  route.push_back(route.front());
  Rng rng(seed);
  const sim::HeadWalk head(route, {}, rng.stream(1));
  Walked walked;
  walked.unit = head.unit(100.0, {}, rng);
  for (double t = 1.0; t < head.duration_s(); t += 1 / 5.5) {
    const auto pose = head.at(t);
    walked.truth_m.emplace_back(pose.position_m.head<2>());
    walked.scans.push_back(
        sim::scan_from_head(planned_route.plan, pose, LogTime::from_seconds(t), {}, rng));
  }
  return walked;
}

PedestrianSlamOptions on_the_head() {
  PedestrianSlamOptions options;
  options.pedestrian.forward = Eigen::Vector3d::UnitX();
  options.pedestrian.length = ConstantStep{0.66};
  options.pedestrian.ahrs.use_magnetometer = false;
  return options;
}

PedestrianSlam follow(const Walked& walked, const PedestrianSlamOptions& options) {
  PedestrianSlam slam(options);
  auto reading = walked.unit.begin();
  for (const LaserScan& scan : walked.scans) {
    for (; reading != walked.unit.end() && reading->time <= scan.time; ++reading)
      slam.add(*reading);
    EXPECT_TRUE(slam.add_scan(scan));
  }
  EXPECT_TRUE(slam.finish());
  return slam;
}

/// Greatest distance from a time on, with the estimate rotated about its start to align the
/// farthest points.
double worst_m(const PedestrianSlam& slam, const Walked& walked, double from_s = 0.0) {
  const Trajectory t = slam.slam().trajectory();
  // Both begin standing; the rotation between the frames follows from their farthest points.
  std::size_t far = 0;
  for (std::size_t i = 0; i < t.size(); ++i)
    if ((walked.truth_m[i] - walked.truth_m[0]).norm() >
        (walked.truth_m[far] - walked.truth_m[0]).norm())
      far = i;
  const auto displacement = [&](std::size_t i) {
    return Eigen::Vector2d(t[i].T_map_base.raw().translation() -
                           t[0].T_map_base.raw().translation());
  };
  const Eigen::Vector2d a = displacement(far), b = walked.truth_m[far] - walked.truth_m[0];
  const SO2d turn(Angle::radians(std::atan2(b.y(), b.x()) - std::atan2(a.y(), a.x())));
  double worst = 0.0;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (t[i].time.seconds() >= from_s)
      worst = std::max(worst,
                       (turn * displacement(i) - (walked.truth_m[i] - walked.truth_m[0])).norm());
  return worst;
}

// Noise is 1 to 5 cm, cells are 5 cm, and a tilt of 3° moves a point 8 m away by a centimetre.
TEST(PedestrianSlam, TracksAWalkerThroughAnOffice) {
  for (const std::uint64_t seed : {1U, 2U}) {
    const Walked walked = walk_through_the_office(seed);
    const PedestrianSlam slam = follow(walked, on_the_head());
    EXPECT_LT(worst_m(slam, walked), 0.15) << seed;
  }
}

TEST(PedestrianSlam, IsDeterministic) {
  const Walked walked = walk_through_the_office(3);
  EXPECT_EQ(follow(walked, on_the_head()).slam().save(),
            follow(walked, on_the_head()).slam().save());
}

// Without returns there are steps along the head's direction, with an error of up to 20°; the test
// is that the walker is found again.
TEST(PedestrianSlam, SurvivesAnInterruptionOfTheUnitOrTheLaser) {
  Walked walked = walk_through_the_office(1);
  Walked no_unit = walked;
  std::erase_if(no_unit.unit, [](const MargSample& s) { return s.time.seconds() > 9.0; });
  EXPECT_LT(worst_m(follow(no_unit, on_the_head()), no_unit), 0.5);
  for (LaserScan& scan : walked.scans)
    if (scan.time.seconds() > 8.0 && scan.time.seconds() < 13.0)
      for (float& range : scan.ranges_m) range = std::numeric_limits<float>::quiet_NaN();
  EXPECT_LT(worst_m(follow(walked, on_the_head()), walked, 18.0), 0.3);
}

// Every fourth scan is missing, others come twice, each late the second time; samples have gaps of
// 0.4 s, longer than the tolerated age.
TEST(PedestrianSlam, SurvivesIrregularScansAndSamples) {
  const Walked walked = walk_through_the_office(2);
  Rng rng(4);
  PedestrianSlam slam(on_the_head());
  Walked taken;
  auto reading = walked.unit.begin();
  for (std::size_t i = 0; i < walked.scans.size(); ++i) {
    if (i > 0 && rng.below(4) == 0) continue;
    const LaserScan& scan = walked.scans[i];
    for (; reading != walked.unit.end() && reading->time <= scan.time; ++reading)
      if (std::fmod(reading->time.seconds(), 6.0) > 0.4) slam.add(*reading);
    ASSERT_TRUE(slam.add_scan(scan)) << i;
    taken.truth_m.push_back(walked.truth_m[i]);
    if (i % 10 == 9) {
      ASSERT_TRUE(slam.add_scan(scan)) << "twice";
      taken.truth_m.push_back(walked.truth_m[i]);
    }
    if (i > 20) {
      EXPECT_FALSE(slam.add_scan(walked.scans[i - 15])) << "out of its turn";
    }
  }
  ASSERT_TRUE(slam.finish());
  ASSERT_EQ(slam.slam().trajectory().size(), taken.truth_m.size());
  EXPECT_LT(worst_m(slam, taken), 0.3);
}

/// Heading of the unit's forward axis at the end, relative to the first scan.
double heading_drift_deg(const Walked& walked, const PedestrianSlamOptions& options) {
  const PedestrianSlam slam = follow(walked, options);
  const Eigen::Vector3d axis = slam.pedestrian().ahrs().q_world_body() * Eigen::Vector3d::UnitX();
  const SE2d& T = slam.slam().local().T_local_base.raw();
  return Angle::radians(std::atan2(axis.y(), axis.x()) - T.heading().radians()).wrapped().degrees();
}

// A gyro bias of 0.5 °/s about the vertical makes 15° in half a minute; the filter estimates it
// from the map's heading, without the disturbed magnetometer.
TEST(PedestrianSlam, GivesTheFilterItsHeading) {
  Walked walked = walk_through_the_office(1);
  for (MargSample& s : walked.unit) {
    s.angular_rate_radps.z() += 0.00873;
    s.magnetic_field_uT = {20.0 * std::sin(s.time.seconds()), 0.0, -40.0};
  }
  PedestrianSlamOptions options = on_the_head();
  options.pedestrian.ahrs.use_magnetometer = true;
  options.pedestrian.ahrs.bias_sigma = 0.00873;
  EXPECT_LT(std::abs(heading_drift_deg(walked, options)), 1.5);
  const PedestrianSlam with_map = follow(walked, options);
  EXPECT_NEAR(with_map.pedestrian().ahrs().gyro_bias_radps().z(), 0.00873, 0.002);
  EXPECT_GT(with_map.pedestrian().report().ahrs.external.used, 15U);
  EXPECT_EQ(with_map.pedestrian().report().ahrs.external.disturbed, 0U);
  EXPECT_EQ(with_map.pedestrian().report().ahrs.magnetometer.used, 0U);
  options.pedestrian.ahrs.use_magnetometer = false;
  options.pedestrian.ahrs.bias_sigma = 1e-4;  // so that rest does not reveal it either
  options.heading = false;
  EXPECT_GT(std::abs(heading_drift_deg(walked, options)), 5.0);
}

// Steps of 0.66 m taken for 0.8 m, with the axis 20° off the direction of motion.
TEST(WalkFeedback, FindsScaleAndDirectionOfSteps) {
  WalkFeedback feedback({.scale_sigma = 0.2});
  const SO2d off(Angle::degrees(-20));
  for (int i = 0; i < 400; ++i) {
    const double s = 0.2 * i;
    const Eigen::Vector2d place(s, 0.3 * std::sin(0.05 * s));
    feedback.add(LogTime::from_seconds(0.18 * i), place, off * (place * (0.8 / 0.66)), true);
  }
  EXPECT_NEAR(feedback.scale(), 0.66 / 0.8, 0.005);
  EXPECT_NEAR(feedback.direction().degrees(), 20.0, 0.5);
}

TEST(WalkFeedback, EstimatesNoScaleInADegenerateScene) {
  WalkFeedback feedback;
  for (int i = 0; i < 100; ++i)
    feedback.add(LogTime::from_seconds(0.18 * i), {0.16 * i, 0.0}, {0.2 * i, 0.0}, false);
  EXPECT_EQ(feedback.scale(), 1.0);
}

// A wall 4 m ahead seen by a scanner pitched down by 10°: its levelled points are 4 m ahead, 0.7 m
// lower; unlevelled, at 4/cos 10°, they would be 6 cm too far.
TEST(LevelScan, ProjectsATiltedScanOntoTheLevelPlane) {
  const SO3d down = SO3d::exp(Eigen::Vector3d(0, Angle::degrees(10).radians(), 0));
  LaserScan scan{{}, Angle::degrees(-30), Angle::degrees(1), 0.1F, 12.0F, {}};
  for (int i = 0; i <= 60; ++i) {
    const double b = scan.bearing(static_cast<std::size_t>(i)).radians();
    const Eigen::Vector3d beam = down * Eigen::Vector3d(std::cos(b), std::sin(b), 0);
    scan.ranges_m.push_back(static_cast<float>(4.0 / beam.x()));
  }
  const LaserScan level = level_scan(scan, down);
  int returned = 0;
  for (std::size_t i = 0; i < level.ranges_m.size(); ++i) {
    if (!level.returned(i)) continue;
    ++returned;
    EXPECT_NEAR(double(level.ranges_m[i]) * std::cos(level.bearing(i).radians()), 4.0, 0.005);
  }
  EXPECT_EQ(returned, 61);
  // 0.7 m down is classified as floor with such options.
  const LaserScan none = level_scan(scan, down, {.lowest_m = -0.5});
  for (std::size_t i = 0; i < none.ranges_m.size(); ++i) EXPECT_FALSE(none.returned(i));
}

// The unit's samples integrate to the true poses.
TEST(HeadWalk, SamplesIntegrateToTheMotion) {
  const sim::HeadWalk head({{0, 0}, {6, 0}, {6, 5}}, {}, Rng(5));
  EXPECT_NEAR(head.path_length_m(), 11.0, 1e-12);
  Rng rng(1);
  const double rate = 500.0;
  const MargRecording unit =
      head.unit(rate, {.gyro_radps = 0, .accel_mps2 = 0, .gyro_bias_per_second = Angle()}, rng);
  SO3d q = head.at(0).q_world_head;
  Eigen::Vector3d v = Eigen::Vector3d::Zero(), p = head.at(0).position_m;
  for (const MargSample& s : unit) {
    const Eigen::Vector3d a = q * s.specific_force_mps2 - 9.80665 * Eigen::Vector3d::UnitZ();
    p += v / rate + 0.5 * a / (rate * rate);
    v += a / rate;
    q = q * SO3d::exp(Eigen::Vector3d(s.angular_rate_radps / rate));
  }
  const auto end = head.at(static_cast<double>(unit.size()) / rate);
  EXPECT_LT((end.q_world_head.inverse() * q).log().norm(), 0.01);
  EXPECT_LT((end.position_m - p).norm(), 0.5);
  EXPECT_NEAR((end.position_m - head.at(0).position_m).head<2>().norm(), std::hypot(6, 5), 0.3);
}

}  // namespace
}  // namespace wayfare
