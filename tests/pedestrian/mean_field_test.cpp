// North by the mean field of a walk.
#include <wayfare/pedestrian/pedestrian.hpp>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "phone_walk.hpp"

namespace wayfare {
namespace {

using testing::PhoneWalkOptions;
using testing::walk_phone;

PedestrianParameters by_mean_field() {
  PedestrianParameters p;
  p.mean_field.on = true;
  p.length = ConstantStep{1.0};
  return p;
}

Pedestrian walked(const MargRecording& samples, const PedestrianParameters& p) {
  Pedestrian pedestrian(p);
  for (const MargSample& s : samples) pedestrian.add(s);
  return pedestrian;
}

/// Adds a field, in the phone's axes, from one time to another, s.
void disturb(MargRecording& samples, double from_s, double to_s, const Eigen::Vector3d& field_uT) {
  for (MargSample& s : samples)
    if (s.time.seconds() >= from_s && s.time.seconds() < to_s) s.magnetic_field_uT += field_uT;
}

// Without disturbances the path has the true directions; a declination of 5° east turns it
// clockwise.
TEST(MeanFieldNorth, GivesTheTrueDirections) {
  const auto walk = walk_phone({});
  const Pedestrian pedestrian = walked(walk.samples, by_mean_field());
  EXPECT_LT((pedestrian.pose().position_m - walk.end).norm(), 0.04 * 80);
  EXPECT_NEAR(pedestrian.pose().heading.radians(), wrap_to_pi(walk.heading_rad), 0.08);
  auto p = by_mean_field();
  p.ahrs.declination = Angle::degrees(5.0);
  const Pedestrian turned = walked(walk.samples, p);
  const Eigen::Vector2d expected =
      Eigen::Rotation2Dd(Angle::degrees(-5.0).radians()) * pedestrian.pose().position_m;
  EXPECT_LT((turned.pose().position_m - expected).norm(), 1e-9);
}

// A bent field on the first third of a straight path turns the causal heading there; the mean
// field turns the whole path, by about a third of it, and the gyro keeps the path straight.
TEST(MeanFieldNorth, KeepsThePathStraight) {
  PhoneWalkOptions o;
  o.turn_radps = 0.0;
  o.start_rad = 0.5 * std::numbers::pi;  // north: the phone's x axis points east
  auto walk = walk_phone(o);
  disturb(walk.samples, 0.0, o.rest_s + o.steps / o.step_hz / 3.0, {18.0, 0.0, 0.0});
  std::vector<double> headings;
  Pedestrian pedestrian(by_mean_field());
  for (const MargSample& s : walk.samples)
    pedestrian.add(s, [&](const PedestrianPose& p) {
      headings.push_back(p.heading.radians() - pedestrian.mean_field().correction());
    });
  ASSERT_GT(headings.size(), 70U);
  for (const double h : headings) EXPECT_NEAR(wrap_to_pi(h - headings.front()), 0.0, 0.06);
  // 18 µT north and in the mean 6 µT east, a third of 18: 18.4° off.
  EXPECT_NEAR(std::abs(wrap_to_pi(pedestrian.pose().heading.radians() - o.start_rad)),
              std::atan2(6.0, 18.0), 0.06);
}

// Standing beside iron before the walk does not count: all readings are at one place.
TEST(MeanFieldNorth, StandingDoesNotCount) {
  PhoneWalkOptions o;
  o.rest_s = 60.0;
  auto walk = walk_phone(o);
  disturb(walk.samples, 0.0, 59.0, {40.0, 0.0, 0.0});
  EXPECT_NEAR(walked(walk.samples, by_mean_field()).pose().heading.radians(),
              wrap_to_pi(walk.heading_rad), 0.1);
}

TEST(MeanFieldNorth, WithoutAFieldIsRelativeToTheStart) {
  auto walk = walk_phone({});
  for (MargSample& s : walk.samples) s.magnetic_field_uT.setConstant(MargSample::kNone);
  const Pedestrian pedestrian = walked(walk.samples, by_mean_field());
  EXPECT_EQ(pedestrian.mean_field().correction(), 0.0);
  EXPECT_GT(pedestrian.report().steps, 70U);
  EXPECT_EQ(pedestrian.report().ahrs.magnetometer.used, 0U);
  EXPECT_EQ(pedestrian.report().ahrs.magnetometer.missing, walk.samples.size());
}

TEST(MeanFieldNorth, RefusesBadReadingsWithoutAnEffect) {
  MeanFieldNorth north({.on = true});
  const auto at = [](double t_s) { return LogTime::from_seconds(t_s); };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(north.add(at(1.0), {}, {nan, 0.0, 0.0}), UpdateStatus::missing);
  EXPECT_EQ(north.add(at(1.0), {}, Eigen::Vector3d::Zero()), UpdateStatus::missing);
  north.step(0.5);
  EXPECT_EQ(north.correction(), 0.0);
  EXPECT_EQ(north.add(at(1.0), {}, {18.0, 0.0, -42.0}), UpdateStatus::used);
  EXPECT_EQ(north.add(at(1.0), {}, {0.0, 18.0, -42.0}), UpdateStatus::late);
  north.step(0.5);
  // North lies along x: the axes turn by a quarter.
  EXPECT_NEAR(north.correction(), 0.5 * std::numbers::pi, 1e-12);
}

}  // namespace
}  // namespace wayfare
