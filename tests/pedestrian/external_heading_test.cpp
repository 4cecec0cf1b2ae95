// Dead reckoning with external headings.

#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/pedestrian/detail/walking_heading.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include "phone_walk.hpp"

namespace wayfare {
namespace {

using testing::PhoneWalk;
using testing::PhoneWalkOptions;
using testing::walk_phone;

// A gyro bias of 1 °/s bends the path; with one external heading per second, 0.2 s late, it is
// straight, including steps made but not yet reported.
TEST(Pedestrian, UsesExternalHeadings) {
  PhoneWalkOptions o;
  o.turn_radps = 0.0;
  PhoneWalk walk = walk_phone(o);
  for (MargSample& s : walk.samples) s.angular_rate_radps.z() += 0.0175;
  PedestrianParameters p;
  p.ahrs.use_magnetometer = false;
  p.ahrs.bias_sigma = 0.0175;
  p.ahrs.heading_history_s = 1.0;
  p.length = ConstantStep{1.0};
  const auto off_course_m = [&](bool external, bool drift_filter) {
    p.magnetic_drift.offset_sigma_uT = drift_filter ? 50.0 : 0.0;
    Pedestrian pedestrian(p);
    for (std::size_t i = 0; i < walk.samples.size(); ++i) {
      const LogTime time = walk.samples[i].time;
      pedestrian.add(walk.samples[i]);
      if (!external || i % 100 != 50) continue;
      const auto status =
          pedestrian.add_heading(time - from_seconds(0.2), Angle::radians(0.4), 3e-4);
      EXPECT_EQ(status, drift_filter ? UpdateStatus::waiting : UpdateStatus::used);
    }
    const Eigen::Vector2d along(std::cos(0.4), std::sin(0.4));
    const Eigen::Vector2d end = pedestrian.pose().position_m;
    return std::abs(along.x() * end.y() - along.y() * end.x());
  };
  EXPECT_LT(off_course_m(true, false), 1.0);    // of 80: 0.7°
  EXPECT_GT(off_course_m(false, false), 10.0);  // and rotated by 0.4 rad from the start
  off_course_m(true, true);
}

TEST(WalkingHeading, RotatesStoredEntries) {
  WalkingHeading heading(0.5);
  constexpr auto kVariance = [] { return 0.1; };
  for (int i = 0; i < 100; ++i) heading.add(LogTime::from_seconds(0.01 * i), 1.0, kVariance);
  heading.rotate(0.25);
  EXPECT_NEAR(heading.now(), 1.25, 1e-12);
  EXPECT_NEAR(heading.at(LogTime::from_seconds(0.5))->radians, 1.25, 1e-12);
  heading.add(LogTime::from_seconds(1.0), 1.25, kVariance);
  EXPECT_NEAR(heading.at(LogTime::from_seconds(1.0))->radians, 1.25, 1e-12);
}

}  // namespace
}  // namespace wayfare
