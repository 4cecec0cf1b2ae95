// Calibration of simulated robots whose geometry is known, and drives and logs it has to refuse.

#include <wayfare/slam/robot_calibration.hpp>

#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/sim/robot_geometry.hpp>
#include <wayfare/sim/worlds.hpp>

namespace wayfare {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

struct KnownDrive {
  Recording recording;
  sim::RobotGeometry truth;
};

KnownDrive known_drive(std::uint64_t seed, bool straight = false) {
  const Rng rng(seed);
  auto world = sim::make_world("calibration_room", rng).value();
  if (straight) world.route_m = {{1.2, 1.2}, {1.2, 6.0}};
  sim::WorldRobot robot = sim::turtlebot(rng);
  robot.robot.drive.max_speed_m_s = 0.5;
  robot.radar.radar.doppler_bins = 64, robot.radar.radar.doppler_bin_m_s /= 4.0;
  robot.radar.period *= 2;
  const sim::RobotGeometry truth = sim::draw_geometry(robot, rng);
  return {sim::simulate_misdescribed(world, robot, truth, rng).value(), truth};
}

const KnownDrive& first_drive() {
  static const KnownDrive drive = known_drive(1);
  return drive;
}

void expect_mounting(const RobotCalibration& c, const std::string& name, const SE2d& truth,
                     double delay_s) {
  const auto value = [&](const char* what) {
    const CalibratedParameter* p = c.find(name + what);
    EXPECT_TRUE(p != nullptr && p->determined) << name << what;
    return p == nullptr ? NAN : p->value;
  };
  EXPECT_NEAR(value(".x"), truth.x(), 0.02) << name;
  EXPECT_NEAR(value(".y"), truth.y(), 0.02) << name;
  const double off =
      std::remainder(value(".yaw") - truth.heading().radians(), 2.0 * std::numbers::pi);
  EXPECT_LT(std::abs(off), Angle::degrees(0.5).radians()) << name;
  EXPECT_NEAR(value(".delay"), delay_s, 0.005) << name;
}

RobotCalibrationOptions fine_bins() {
  RobotCalibrationOptions options;
  options.velocity.inlier_m_s = 0.076, options.velocity.doppler_sigma_m_s = 0.009;
  return options;
}

/// Within three standard deviations where it is determined, and the value given where not.
void expect_consistent(const RobotCalibration& c, const std::string& name, double truth,
                       double largest_sigma) {
  const CalibratedParameter* p = c.find(name);
  ASSERT_NE(p, nullptr) << name;
  EXPECT_LT(p->sigma, largest_sigma) << name;
  if (p->determined) {
    EXPECT_LT(std::abs(p->value - truth), 3.0 * p->sigma) << name;
  } else {
    EXPECT_EQ(p->value, p->given) << name;
  }
}

TEST(RobotCalibration, FindsAKnownGeometry) {
  const KnownDrive& d = first_drive();
  const auto c = calibrate_robot(d.recording, fine_bins());
  ASSERT_TRUE(c) << c.error().to_string();
  EXPECT_NEAR(c->find("wheels.left_scale")->value, d.truth.left_scale, 0.005);
  EXPECT_NEAR(c->find("wheels.right_scale")->value, d.truth.right_scale, 0.005);
  EXPECT_NEAR(c->find("wheels.base")->value, d.truth.wheel_base_m, 0.01 * d.truth.wheel_base_m);
  expect_mounting(*c, "laser", d.truth.T_base_laser, d.truth.laser_delay_s);
  expect_consistent(*c, "radar.x", d.truth.T_base_radar.x(), 0.04);
  expect_consistent(*c, "radar.y", d.truth.T_base_radar.y(), 0.04);
  expect_consistent(*c, "radar.yaw", d.truth.T_base_radar.heading().radians(), 0.03);
  expect_consistent(*c, "radar.delay", d.truth.radar_delay_s, 0.015);
  EXPECT_NEAR(c->find("gyro.delay")->value, d.truth.gyro_delay_s, 0.005);
  EXPECT_NEAR(c->find("gyro.scale")->value, 1.0, 0.01);
  ASSERT_EQ(c->covariance.rows(), static_cast<Eigen::Index>(c->parameters.size()));
  EXPECT_TRUE(c->covariance.allFinite());
}

TEST(RobotCalibration, TheSameAgainAndAppliedNothingIsLeft) {
  const KnownDrive& d = first_drive();
  const auto once = calibrate_robot(d.recording, fine_bins()),
             twice = calibrate_robot(d.recording, fine_bins());
  ASSERT_TRUE(once && twice);
  for (std::size_t i = 0; i < once->parameters.size(); ++i)
    EXPECT_EQ(once->parameters[i].value, twice->parameters[i].value);
  const auto again = calibrate_robot(once->applied_to(d.recording), fine_bins());
  ASSERT_TRUE(again) << again.error().to_string();
  for (const CalibratedParameter& p : again->parameters)
    if (once->find(p.name)->determined) {
      EXPECT_NEAR(p.value, p.given, std::max(p.sigma, 1e-4)) << p.name;
    }
}

TEST(RobotCalibration, WithoutRadarOrLaserTheOtherIsCalibrated) {
  KnownDrive d = first_drive();
  const auto radar = std::exchange(d.recording.radar, {});
  const auto by_laser = calibrate_robot(d.recording, fine_bins());
  ASSERT_TRUE(by_laser) << by_laser.error().to_string();
  expect_mounting(*by_laser, "laser", d.truth.T_base_laser, d.truth.laser_delay_s);
  EXPECT_EQ(by_laser->find("radar.x"), nullptr);
  EXPECT_THAT(by_laser->notes, Contains("radar: no data"));
  d.recording.radar = radar;
  d.recording.scans.clear();
  const auto by_radar = calibrate_robot(d.recording, fine_bins());
  ASSERT_TRUE(by_radar) << by_radar.error().to_string();
  expect_consistent(*by_radar, "radar.yaw", d.truth.T_base_radar.heading().radians(), 0.03);
  EXPECT_EQ(by_radar->find("laser_to_radar.x"), nullptr);
}

TEST(RobotCalibration, WithoutWheelsRadarToLaser) {
  KnownDrive d = first_drive();
  d.recording.wheels.clear(), d.recording.odometry.clear();
  const auto c = calibrate_robot(d.recording, fine_bins());
  ASSERT_TRUE(c) << c.error().to_string();
  EXPECT_EQ(c->find("wheels.base"), nullptr);
  EXPECT_EQ(c->find("laser.x"), nullptr);
  const SE2d truth = d.truth.T_base_laser.inverse() * d.truth.T_base_radar;
  expect_consistent(*c, "laser_to_radar.yaw", truth.heading().radians(), 0.05);
}

TEST(RobotCalibration, AStraightDriveLeavesOpenWhatItDoesNotShow) {
  const KnownDrive d = known_drive(2, true);
  const auto c = calibrate_robot(d.recording, fine_bins());
  ASSERT_TRUE(c) << c.error().to_string();
  const auto open = c->undetermined();
  for (const char* name : {"wheels.base", "laser.x", "laser.y", "radar.x", "radar.y"})
    EXPECT_THAT(open, Contains(name));
  // No number is made up: what is open keeps the value given.
  for (const CalibratedParameter& p : c->parameters)
    if (!p.determined) {
      EXPECT_EQ(p.value, p.given) << p.name;
    }
  EXPECT_TRUE(std::isinf(c->find("laser.y")->sigma));
}

TEST(RobotCalibration, NamesWrongUnitsAndSides) {
  const auto refused = [](const char* why, auto change) {
    Recording r = first_drive().recording;
    change(r);
    const auto c = calibrate_robot(r);
    ASSERT_FALSE(c) << why;
    EXPECT_EQ(c.error().code, ErrorCode::invalid);
    EXPECT_THAT(c.error().message, HasSubstr(why));
  };
  refused("millimetres", [](Recording& r) {
    for (WheelSample& w : r.wheels) w.left_m *= 1000.0, w.right_m *= 1000.0;
  });
  refused("degrees", [](Recording& r) {
    for (GyroSample& g : r.gyro) g.turn_rate_rad_s *= 57.2957795;
  });
  refused("exchanged", [](Recording& r) {
    for (WheelSample& w : r.wheels) std::swap(w.left_m, w.right_m);
  });
  refused("exchanged", [](Recording& r) {
    for (GyroSample& g : r.gyro) g.turn_rate_rad_s = -g.turn_rate_rad_s;
  });
}

TEST(RobotCalibration, BridgesASilenceAndReportsIt) {
  KnownDrive d = first_drive();
  const LogTime from = d.recording.truth.front().time + Duration(20'000'000'000);
  const auto silent = [&](LogTime t) { return t > from && t < from + Duration(12'000'000'000); };
  std::erase_if(d.recording.wheels, [&](const WheelSample& w) { return silent(w.time); });
  std::erase_if(d.recording.radar,
                [&](const RadarScan& s) { return silent(s.time - Duration(20'000'000'000)); });
  const auto c = calibrate_robot(d.recording, fine_bins());
  ASSERT_TRUE(c) << c.error().to_string();
  expect_mounting(*c, "laser", d.truth.T_base_laser, d.truth.laser_delay_s);
  EXPECT_THAT(c->notes, Contains(HasSubstr("wheels silent for 12.")));
  EXPECT_THAT(c->notes, Contains(HasSubstr("radar silent for 12.")));
}

TEST(RobotCalibration, RefusesWhatCannotBeCalibrated) {
  EXPECT_EQ(calibrate_robot(Recording{}).error().code, ErrorCode::not_found);
  Recording r = first_drive().recording;
  r.scans.clear(), r.radar.clear();
  EXPECT_EQ(calibrate_robot(r).error().code, ErrorCode::not_found);
  r = first_drive().recording;
  r.scans.resize(10), r.radar.clear();
  EXPECT_EQ(calibrate_robot(r).error().code, ErrorCode::degenerate);
  const auto stopped = calibrate_robot(first_drive().recording, {}, [](double) { return false; });
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace wayfare
