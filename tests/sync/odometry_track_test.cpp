#include <wayfare/sync/odometry_track.hpp>

#include <vector>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

OdometrySample sample(double t, double x, Angle heading) {
  return {LogTime::from_seconds(t), Transform2<frame::Odom, frame::Base>(SE2d(x, 0.0, heading))};
}

TEST(OdometryTrack, IsEmptyWithoutSamples) {
  EXPECT_FALSE(OdometryTrack({}).at(LogTime{}).has_value());
}

TEST(OdometryTrack, ClampsAtTheEndsAndInterpolatesBetween) {
  const std::vector<OdometrySample> samples = {sample(1.0, 0.0, 0_deg), sample(2.0, 4.0, 0_deg)};
  const OdometryTrack track(samples);
  EXPECT_EQ(track.at(LogTime::from_seconds(0.5))->raw().x(), 0.0);
  EXPECT_EQ(track.at(LogTime::from_seconds(9.0))->raw().x(), 4.0);
  EXPECT_NEAR(track.at(LogTime::from_seconds(1.25))->raw().x(), 1.0, 1e-12);
}

TEST(OdometryTrack, InterpolatesTheShortRotationAcrossPi) {
  const std::vector<OdometrySample> samples = {sample(0.0, 0.0, 170_deg),
                                               sample(1.0, 0.0, -170_deg)};
  const double half =
      OdometryTrack(samples).at(LogTime::from_seconds(0.5))->raw().heading().degrees();
  EXPECT_NEAR(std::abs(half), 180.0, 1e-9);
}

TEST(OdometryTrack, TakesTheLaterOfTwoSamplesAtOneTime) {
  const std::vector<OdometrySample> samples = {sample(0.0, 0.0, 0_deg), sample(1.0, 1.0, 0_deg),
                                               sample(1.0, 2.0, 0_deg), sample(2.0, 3.0, 0_deg)};
  EXPECT_EQ(OdometryTrack(samples).at(LogTime::from_seconds(1.0))->raw().x(), 2.0);
}

}  // namespace
}  // namespace wayfare
