#include <wayfare/eval/relations.hpp>

#include <cmath>
#include <string>

#include <wayfare/io/carmen.hpp>
#include <wayfare/io/tum.hpp>
#include "core/at.hpp"
#include "io/support.hpp"

namespace wayfare::eval {
namespace {

using tests::at;

StampedPose sample(double t, double x, double y, double degrees) {
  return {at(t), Transform2<frame::Map, frame::Base>(SE2d(x, y, Angle::degrees(degrees)))};
}

TEST(Relations, GoldenByHand) {
  // Straight along x at 1 m/s for 2 s, then a quarter turn in place.
  const Trajectory trajectory = {sample(0, 0, 0, 0), sample(2, 2, 0, 0), sample(3, 2, 0, 90)};
  const std::vector<Relation> relations = {
      {at(0.5), at(1.5), SE2d(1, 0, Angle())},             // exact, both interpolated
      {at(0), at(2), SE2d(1.7, 0.4, Angle::degrees(10))},  // error (0.3, -0.4), 10°
      {at(2), at(2.5), SE2d(0, 0, Angle::degrees(47))},    // half the turn is 45°: error 2°
      {at(3), at(1), SE2d(0, 1, Angle::degrees(-90))},  // backwards, relative to the rotated robot
      {at(-1), at(2), SE2d()},                          // starts before the trajectory
      {at(0), at(3.0001), SE2d()},                      // ends after it
  };
  const RelationsResult result = relations_error(trajectory, relations);
  EXPECT_EQ(result.used, 4U);
  EXPECT_EQ(result.outside, 2U);
  const double translations[] = {0.0, 0.5, 0.0, 0.0};
  const double rotations[] = {0.0, 10.0, 2.0, 0.0};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(result.errors[i].translation_m, translations[i], 1e-12) << i;
    EXPECT_NEAR(result.errors[i].rotation_deg, rotations[i], 1e-9) << i;
  }
  EXPECT_NEAR(result.translation_m.mean, 0.125, 1e-12);
  // Deviations -1/8 three times and 3/8 once: variance (3/64 + 9/64)/4 = 3/64.
  EXPECT_NEAR(result.translation_m.std, std::sqrt(3.0 / 64), 1e-12);
  EXPECT_NEAR(result.translation_m.max, 0.5, 1e-12);
  EXPECT_NEAR(result.rotation_deg.mean, 3.0, 1e-9);
}

TEST(Relations, DoNotDependOnTheFrameOfTheMap) {
  Trajectory a, b;
  const SE2d move(3, -7, Angle::degrees(123));
  std::vector<Relation> relations;
  for (int i = 0; i < 50; ++i) {
    a.push_back(sample(i, std::cos(0.1 * i), 0.3 * i, 17 * i));
    b.push_back({at(i), Transform2<frame::Map, frame::Base>(move * a.back().T_map_base.raw())});
    relations.push_back({at(i * 0.7), at(i * 0.9), SE2d(0.1, 0.2, Angle::degrees(5))});
  }
  const RelationsResult ra = relations_error(a, relations), rb = relations_error(b, relations);
  EXPECT_NEAR(ra.translation_m.mean, rb.translation_m.mean, 1e-12);
  EXPECT_NEAR(ra.rotation_deg.mean, rb.rotation_deg.mean, 1e-9);
}

TEST(Relations, AcrossALargeGapAreNotUsed) {
  const Trajectory trajectory = {sample(0, 0, 0, 0), sample(1, 1, 0, 0), sample(9, 9, 0, 0)};
  const std::vector<Relation> relations = {{at(0.5), at(5), SE2d()}, {at(0.5), at(9), SE2d()}};
  const RelationsResult result =
      relations_error(trajectory, relations, {.gaps = {.largest_gap = from_seconds(2)}});
  EXPECT_EQ(result.outside, 1U);
  EXPECT_EQ(result.used, 1U);
}

TEST(Relations, MayEndAtTheNearestPose) {
  const Trajectory trajectory = {sample(0, 0, 0, 0), sample(1, 1, 0, 30), sample(2, 3, 0, 50)};
  // From x = 0 to x = 1, and from there to the last: 2 m at 30 degrees.
  const std::vector<Relation> relations = {
      {at(0.4), at(1.4), SE2d(1, 0, Angle::degrees(30))},
      {at(1), at(1.6), SE2d(2 * std::cos(M_PI / 6), -1, Angle::degrees(20))}};
  const RelationsResult result = relations_error(trajectory, relations, {.nearest_pose = true});
  EXPECT_EQ(result.used, 2U);
  EXPECT_NEAR(result.translation_m.max, 0.0, 1e-12);
  EXPECT_NEAR(result.rotation_deg.max, 0.0, 1e-9);
  EXPECT_GT(relations_error(trajectory, relations).rotation_deg.max, 1.0);
}

TEST(Relations, EmptyInput) {
  const RelationsResult result = relations_error({}, std::vector<Relation>(3));
  EXPECT_EQ(result.outside, 3U);
  EXPECT_TRUE(std::isnan(result.translation_m.mean));
}

/// Published figures of the wheel odometry of two logs, to their rounding.
TEST(Relations, RealOdometry) {
  struct Expected {
    const char* name;
    std::size_t used, outside;
    double translation_m, rotation_deg, rotation_rounding;
  };
  for (const Expected& e : {Expected{"intel", 2945, 39, 7.22, 40.1, 0.05},
                            Expected{"fr079", 1685, 0, 6.51, 30.0, 0.5}}) {
    WAYFARE_NEEDS_RECORDING(log_path, "slam2d/" + std::string(e.name) + ".clf.gz");
    WAYFARE_NEEDS_RECORDING(relations_path, "slam2d/" + std::string(e.name) + ".relations.gz");
    const auto log = io::read_carmen(log_path);
    const auto file = io::read_relations(relations_path);
    ASSERT_TRUE(log && file);
    const RelationsResult result =
        relations_error(as_trajectory(log->recording.odometry), file->relations);
    EXPECT_EQ(result.used, e.used) << e.name;
    EXPECT_EQ(result.outside, e.outside) << e.name;
    EXPECT_NEAR(result.translation_m.mean, e.translation_m, 0.005) << e.name;
    EXPECT_NEAR(result.rotation_deg.mean, e.rotation_deg, e.rotation_rounding) << e.name;
  }
}

}  // namespace
}  // namespace wayfare::eval
