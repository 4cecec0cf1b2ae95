#include <wayfare/eval/nav_error.hpp>

#include <cmath>
#include <initializer_list>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace wayfare::eval {
namespace {

const Geodetic kOrigin{Angle::degrees(48.0), Angle::degrees(11.0), 500.0};

/// Northwards at 10 m/s, at these times, with an offset to the east.
NavTrajectory northwards(std::initializer_list<double> times_s, double east_m = 0.0) {
  NavTrajectory states;
  for (const double t : times_s)
    states.push_back({LogTime::from_seconds(t),
                      geodetic_from_ned({10.0 * t, east_m, 0.0}, kOrigin),
                      {10.0, 0.0, 0.0},
                      {}});
  return states;
}

std::vector<GnssInsPoint> points_of(const NavTrajectory& states) {
  std::vector<GnssInsPoint> points;
  for (const NavState& s : states) {
    GnssInsPoint point;
    point.nav = s;
    point.sigma.setConstant(2.0F);
    point.imu_errors.setZero();
    points.push_back(point);
  }
  return points;
}

TEST(NavReference, IsInterpolatedButNotAcrossGaps) {
  const NavReference reference{northwards({0.0, 1.0, 4.0}), true, false};
  const auto middle = reference_at(reference, LogTime::from_seconds(0.25));
  ASSERT_TRUE(middle);
  EXPECT_NEAR(ned_from_geodetic(middle->position, kOrigin).x(), 2.5, 1e-6);
  EXPECT_NEAR(middle->velocity_ned_mps.x(), 10.0, 1e-12);
  EXPECT_TRUE(reference_at(reference, LogTime::from_seconds(4.0)));
  for (const double t : {-0.1, 2.0, 4.1})
    EXPECT_FALSE(reference_at(reference, LogTime::from_seconds(t))) << t;
}

TEST(NavErrorSeries, ComparesTheAntennaAndLeavesUnknownsOut) {
  const NavReference reference{northwards({0.0, 0.4, 0.8}), true, false};
  const auto points = points_of(northwards({0.0, 0.4, 0.8}, 3.0));
  const NavErrors e = nav_errors(points, reference, {0.0, 1.0, 0.0}, LogTime());
  ASSERT_EQ(e.time_s.size(), 3U);
  EXPECT_DOUBLE_EQ(e.time_s[1], 0.4);
  EXPECT_NEAR(e.error[1][1], 4.0, 1e-3);  // three to the east, and the antenna a metre to the right
  EXPECT_NEAR(e.horizontal(1), 4.0, 1e-3);
  EXPECT_NEAR(e.error[3][1], 0.0, 1e-12);
  EXPECT_TRUE(std::isnan(e.error[6][1]));  // no attitude …
  EXPECT_NEAR(e.error[8][1], 0.0, 1e-9);   // … but a course
  EXPECT_NEAR(e.sigma[8][1], 2.0 * 180.0 / std::numbers::pi, 1e-3);
}

TEST(PlainGnss, IsTheFixesWithoutRanges) {
  const NavReference reference{northwards({0.0, 1.0}), true, false};
  GnssInsRecording recording;
  recording.imu.resize(1);
  recording.fixes.resize(2);
  recording.fixes[0].time = LogTime::from_seconds(0.5);
  recording.fixes[0].position = geodetic_from_ned({5.0, 1.0, 0.0}, kOrigin);
  recording.fixes[1].time = LogTime::from_seconds(9.0);
  const PlainGnss plain = plain_gnss(recording, reference);
  ASSERT_EQ(plain.time_s.size(), 2U);
  EXPECT_NEAR(plain.error_ned_m[0].y(), 1.0, 1e-6);
  EXPECT_TRUE(plain.error_ned_m[1].hasNaN());
}

}  // namespace
}  // namespace wayfare::eval
