// Forward or backward from scans, for wheels that count without sign.

#include <wayfare/nav/travel_direction.hpp>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <wayfare/sim/worlds.hpp>

namespace wayfare {
namespace {

/// A robot that drives along x, with scans every 0.2 s at `speed_of(i)`, and wheels without sign.
template <class Speed>
Recording drive_in(const sim::FloorPlan& plan, int scans, const Speed& speed_of,
                   double turn_rad_s) {
  Recording r;
  Rng rng(5);
  SE2d pose(-2.0, 0.1, Angle::radians(0.05));
  sim::Lidar2dParams lidar = sim::CorridorDriveParams::lms200();
  for (int i = 0; i < scans; ++i) {
    const double v = i > 0 ? speed_of(i) : 0.0;
    pose = pose * SE2d(0.2 * v, 0.0, Angle::radians(i > 0 ? 0.2 * turn_rad_s : 0.0));
    const LogTime time = LogTime::from_seconds(10.0 + 0.2 * i);
    r.scans.push_back(sim::simulate_scan(
        plan, [&](LogTime) { return pose; }, time, lidar, rng));
  }
  return r;
}

template <class Speed>
std::vector<MotionSample> unsigned_motion(const Recording& r, const Speed& speed_of,
                                          double turn_rad_s) {
  std::vector<MotionSample> motion;
  for (std::size_t i = 0; i < r.scans.size(); ++i)
    motion.push_back({r.scans[i].time, turn_rad_s, std::abs(speed_of(static_cast<int>(i)))});
  return motion;
}

std::vector<sim::Segment> room() {
  return {{{-5, -3}, {5, -3}}, {{5, -3}, {5, 3}},  {{5, 3}, {-5, 3}},
          {{-5, 3}, {-5, -3}}, {{1, -3}, {1, -2}}, {{2, 1}, {2.5, 1.5}}};
}

/// A metre and a half ahead, then as far back.
double ahead_and_back(int i) { return i < 25 ? 0.3 : -0.3; }

TEST(TravelDirection, FindsWhereARobotDrivesBackInARoom) {
  const auto plan = sim::FloorPlan::from_segments(room());
  // The turn rate that the motion reports is wrong by 0.2 rad/s.
  for (const double turn : {0.0, 0.1}) {
    const Recording r = drive_in(*plan, 50, ahead_and_back, turn);
    const auto motion = unsigned_motion(r, ahead_and_back, turn + 0.2);
    ASSERT_TRUE(counts_without_sign(motion));
    const SignedMotion found = sign_motion(r, motion);
    int wrong = 0;
    for (int i = 1; i < 50; ++i)
      wrong += found.motion[static_cast<std::size_t>(i)].speed_m_s * ahead_and_back(i) < 0.0;
    EXPECT_LE(wrong, 3);  // those right after the reversal
    EXPECT_NEAR(static_cast<double>(found.reversed), 25.0, 3.0);
  }
}

TEST(TravelDirection, ABareCorridorDoesNotTell) {
  const auto plan = sim::FloorPlan::from_segments({{{-100, -1}, {100, -1}}, {{100, 1}, {-100, 1}}});
  const Recording r = drive_in(*plan, 40, ahead_and_back, 0.0);
  EXPECT_EQ(sign_motion(r, unsigned_motion(r, ahead_and_back, 0.0)).reversed, 0U);
}

TEST(TravelDirection, MotionAndScansThatAreNotUsableChangeNothing) {
  TravelDirection direction;
  const auto plan = sim::FloorPlan::from_segments(room());
  const Recording r = drive_in(*plan, 2, ahead_and_back, 0.0);
  EXPECT_EQ(direction.add(LaserScan{}, 0.1, 0.0), 1);
  EXPECT_EQ(direction.add(r.scans[0], 0.1, 0.0), 1);
  const double before = direction.log_odds();
  EXPECT_EQ(direction.add(r.scans[1], std::nan(""), 0.0), 1);
  EXPECT_EQ(direction.add(r.scans[1], 0.1, std::numeric_limits<double>::infinity()), 1);
  LaserScan nothing = r.scans[1];
  for (float& range : nothing.ranges_m) range = std::nanf("");
  EXPECT_EQ(direction.add(nothing, 0.1, 0.0), 1);
  EXPECT_LE(direction.log_odds(), before);  // a scan without returns only lets certainty decay
}

TEST(TravelDirection, TellsWheelsThatNeverCountBackwards) {
  const auto at = [](double t, double v) { return MotionSample{LogTime::from_seconds(t), 0.0, v}; };
  EXPECT_FALSE(counts_without_sign({}));
  EXPECT_FALSE(counts_without_sign(std::vector{at(0, 0.0), at(1, 0.0)}));
  EXPECT_TRUE(counts_without_sign(std::vector{at(0, 0.5), at(1, 0.0)}));
  EXPECT_FALSE(counts_without_sign(std::vector{at(0, 0.5), at(1, -0.2)}));
}

}  // namespace
}  // namespace wayfare
