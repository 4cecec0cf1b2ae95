#include "support/slam_doubt.hpp"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace wayfare::examples {
namespace {

using ::testing::HasSubstr;

/// A square of 10 m, 0.5 m or 15 degrees a second, `laps` times; as odometry with its lengths and
/// turns multiplied.
Recording square(int laps, double length, double turn) {
  Recording recording;
  SE2d pose;
  int second = 0;
  const auto add = [&] {
    recording.odometry.push_back({LogTime::from_nanoseconds(second++ * 1'000'000'000LL),
                                  Transform2<frame::Odom, frame::Base>(pose)});
  };
  add();
  for (int side = 0; side < 4 * laps; ++side) {
    for (int i = 0; i < 20; ++i, add()) pose = pose * SE2d(0.5 * length, 0.0, Angle{});
    for (int i = 0; i < 6; ++i, add()) pose = pose * SE2d(0.0, 0.0, Angle::degrees(15.0 * turn));
  }
  return recording;
}

std::string doubt_of(const Recording& odometry, int laps = 3) {
  Doubt doubt;
  doubt_odometry(doubt, odometry, as_trajectory(square(laps, 1.0, 1.0).odometry));
  return doubt.why;
}

TEST(DoubtOfOdometry, NamesLeaps) {
  Recording recording = square(1, 1.0, 1.0);
  Doubt doubt;
  doubt_leaps(doubt, recording);
  EXPECT_EQ(doubt.why, "");
  recording.odometry[40].T_odom_base =
      Transform2<frame::Odom, frame::Base>(SE2d(40.0, 0.0, Angle{}));  // there and back
  doubt_leaps(doubt, recording);
  EXPECT_THAT(doubt.why, HasSubstr("odometry leaps at 2 of its samples"));
}

/// Along x at 1 m/s, a scan a second, `leap_m` on from the twentieth.
Trajectory straight(double leap_m) {
  Trajectory path;
  for (int i = 0; i < 40; ++i)
    path.push_back({LogTime() + from_seconds(i), Transform2<frame::Map, frame::Base>(SE2d(
                                                     i + (i < 20 ? 0.0 : leap_m), 0.0, Angle{}))});
  return path;
}

// A step of the usual metre may be 1 m + 2 * 1 m/s * 1 s long.
TEST(DoubtOfPath, NamesLeapsThatOdometryDoesNotKnow) {
  const auto doubt_of_leap = [](double leap_m, double of_odometry_m) {
    Recording recording;
    for (const StampedPose& pose : straight(of_odometry_m))
      recording.odometry.push_back(
          {pose.time, Transform2<frame::Odom, frame::Base>(pose.T_map_base.raw())});
    Doubt doubt;
    doubt_path_leaps(doubt, recording, straight(leap_m));
    Doubt without;
    doubt_path_leaps(without, {}, straight(leap_m));
    EXPECT_EQ(without.why.empty(), leap_m < 2.0);
    return doubt.why;
  };
  EXPECT_EQ(doubt_of_leap(1.9, 0.0), "");
  EXPECT_THAT(doubt_of_leap(2.1, 0.0), HasSubstr("leaps at 1 of its scans, by at most 3.1 m"));
  EXPECT_EQ(doubt_of_leap(2.1, 5.0), "") << "the robot was carried, and odometry set";
}

TEST(DoubtOfScans, NamesALongGapWithoutOdometry) {
  Recording recording;
  for (const double t : {0.0, 0.2, 0.4, 0.6, 5.7, 5.9}) {
    LaserScan& scan = recording.scans.emplace_back();
    scan.time = LogTime() + from_seconds(t);
  }
  Doubt doubt;
  doubt_gaps(doubt, recording);
  EXPECT_THAT(doubt.why, HasSubstr("no scan was taken for 5.1 s"));
  Doubt none;
  recording.odometry = square(1, 1.0, 1.0).odometry;
  doubt_gaps(none, recording);
  recording.odometry.clear();
  recording.scans.resize(4);  // 0.2 s each
  doubt_gaps(none, recording);
  EXPECT_EQ(none.why, "");
}

TEST(DoubtOfWalls, NamesWhatIsAboveItsLimit) {
  for (const WallCrossings& crossings : {WallCrossings{0.11, 0.2}, WallCrossings{0.05, 0.4}}) {
    Doubt doubt;
    doubt_walls(doubt, crossings, 0.1, 0.3);
    EXPECT_THAT(doubt.why, HasSubstr("of the rays cross walls"));
  }
  Doubt none;
  doubt_walls(none, {0.1, 0.3}, 0.1, 0.3);
  EXPECT_EQ(none.why, "");
}

// 12 sides of 10 m with 12 corners of 90 degrees between them.
TEST(DoubtOfOdometry, NamesLengthsAndTurnsThatContradictThePath) {
  EXPECT_EQ(doubt_of(square(3, 1.0, 1.0)), "");
  EXPECT_EQ(doubt_of(square(3, 0.8, 0.8)), "") << "a fifth is a poor calibration";
  EXPECT_THAT(doubt_of(square(3, 0.1, 1.0)),
              HasSubstr("stretches of 2 m in which odometry contradicts the estimated path"));
  EXPECT_THAT(doubt_of(square(3, 1.0, -1.0)),
              HasSubstr("turns in which odometry contradicts the estimated path"));
}

TEST(DoubtOfOdometry, NeedsFiveStretchesAndOdometry) {
  EXPECT_EQ(doubt_of({}), "");
  Recording slow = square(1, 0.0, 1.0);
  slow.odometry.resize(18);  // 8.5 m: four stretches
  EXPECT_EQ(doubt_of(slow), "");
}

TEST(Doubt, OfAShareNamesBothNumbers) {
  Doubt doubt;
  doubt_share(doubt, 5, 10, "scans are refused");
  EXPECT_EQ(doubt.why, "");
  doubt_share(doubt, 6, 10, "scans are refused");
  doubt_share(doubt, 2, 10, "scans do not match", 0.1);
  EXPECT_EQ(doubt.why, "6 of 10 scans are refused; 2 of 10 scans do not match");
}

}  // namespace
}  // namespace wayfare::examples
