#include <wayfare/eval/trajectory_error.hpp>

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare::eval {
namespace {

StampedPose sample(double t, const SE2d& pose) {
  return {LogTime::from_seconds(t), Transform2<frame::Map, frame::Base>(pose)};
}

TEST(Interpolation, InsideOutsideAndOnASample) {
  const Trajectory t = {sample(1, SE2d()), sample(2, SE2d(1, 0, Angle())),
                        sample(2, SE2d(5, 0, Angle())), sample(4, SE2d(1, 0, Angle::degrees(90)))};
  EXPECT_FALSE(pose_at(t, LogTime::from_seconds(0.999)));
  EXPECT_FALSE(pose_at(t, LogTime::from_seconds(4.001)));
  EXPECT_FALSE(pose_at({}, LogTime()));
  EXPECT_EQ(pose_at(t, LogTime::from_seconds(1))->x(), 0.0);
  EXPECT_NEAR(pose_at(t, LogTime::from_seconds(1.25))->x(), 0.25, 1e-15);
  EXPECT_EQ(pose_at(t, LogTime::from_seconds(2))->x(), 1.0);  // the first of two at one time
  EXPECT_NEAR(pose_at(t, LogTime::from_seconds(3))->heading().degrees(), 45.0, 1e-12);
  EXPECT_FALSE(pose_at(t, LogTime::from_seconds(3), {from_seconds(1)}));
  EXPECT_TRUE(pose_at(t, LogTime::from_seconds(4), {from_seconds(1)}));
}

TEST(Interpolation, TakesTheShorterRotation) {
  const Trajectory t = {sample(0, SE2d(0, 0, Angle::degrees(170))),
                        sample(1, SE2d(0, 0, Angle::degrees(-170)))};
  EXPECT_NEAR(std::abs(pose_at(t, LogTime::from_seconds(0.5))->heading().degrees()), 180.0, 1e-9);
}

TEST(Statistics, GoldenByHand) {
  const double values[] = {3, 1, 2, 10};
  const Summary s = summarise(values);
  EXPECT_EQ(s.mean, 4.0);
  EXPECT_NEAR(s.std, std::sqrt((1 + 9 + 4 + 36) / 4.0), 1e-15);
  EXPECT_NEAR(s.rmse, std::sqrt((9 + 1 + 4 + 100) / 4.0), 1e-15);
  EXPECT_EQ(s.median, 2.5);
  EXPECT_EQ(s.max, 10.0);
  EXPECT_EQ(median_of({5, 1, 9}), 5.0);
  EXPECT_TRUE(std::isnan(summarise({}).rmse));
}

TEST(AbsoluteError, GoldenByHandWithoutAlignment) {
  // The truth runs 4 m along x; the estimate has errors (0, 0), (0, 1), (3, 4) and 90°.
  const Trajectory truth = {sample(0, SE2d()), sample(4, SE2d(4, 0, Angle()))};
  const Trajectory estimate = {sample(-1, SE2d()), sample(0, SE2d()),
                               sample(1, SE2d(1, 1, Angle())),
                               sample(4, SE2d(7, 4, Angle::degrees(90)))};
  const AbsoluteError e = absolute_error(estimate, truth, {.alignment = Alignment::none});
  EXPECT_EQ(e.unmatched, 1U);
  EXPECT_EQ(e.translation_m.count, 3U);
  EXPECT_NEAR(e.translation_m.mean, 2.0, 1e-12);
  EXPECT_NEAR(e.translation_m.median, 1.0, 1e-12);
  EXPECT_NEAR(e.translation_m.max, 5.0, 1e-12);
  EXPECT_NEAR(e.translation_m.rmse, std::sqrt(26.0 / 3), 1e-12);
  EXPECT_NEAR(e.rmse_x_m, std::sqrt(9.0 / 3), 1e-12);
  EXPECT_NEAR(e.rmse_y_m, std::sqrt(17.0 / 3), 1e-12);
  EXPECT_NEAR(e.rmse_heading_deg, 90.0 / std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(e.path_length_m, 4.0, 1e-12);
  EXPECT_NEAR(e.percent_of_path, 25.0 * std::sqrt(26.0 / 3), 1e-9);
}

Trajectory wander(int n) {
  Rng rng(3);
  Trajectory t;
  SE2d pose;
  for (int i = 0; i < n; ++i) {
    t.push_back(sample(i, pose));
    pose = pose.plus(Eigen::Vector3d(1 + 0.1 * rng.normal(), 0, 0.3 * rng.normal()));
  }
  return t;
}

TEST(AbsoluteError, RigidAlignmentRemovesAnyMotionOfTheMap) {
  const Trajectory truth = wander(200);
  const SE2d move(-30, 12, Angle::degrees(200));
  Trajectory estimate;
  for (const StampedPose& s : truth)
    estimate.push_back({s.time, Transform2<frame::Map, frame::Base>(move * s.T_map_base.raw())});
  const AbsoluteError aligned = absolute_error(estimate, truth);
  EXPECT_LT(aligned.translation_m.max, 1e-9);
  EXPECT_LT(aligned.heading_deg.max, 1e-9);
  EXPECT_LT(aligned.alignment.minus(move.inverse()).norm(), 1e-9);
  EXPECT_GT(absolute_error(estimate, truth, {.alignment = Alignment::none}).translation_m.mean, 5);
}

TEST(RelativeError, ByTimeAndByDistance) {
  // The truth runs at 1 m/s along x; the estimate 2 % too far.
  Trajectory truth, estimate;
  for (int i = 0; i <= 100; ++i) {
    truth.push_back(sample(i, SE2d(i, 0, Angle())));
    estimate.push_back(sample(i, SE2d(1.02 * i, 0, Angle())));
  }
  const std::vector<PosePair> pairs = associate(estimate, truth);
  ASSERT_EQ(pairs.size(), 101U);
  const RelativeError second = relative_error(pairs, Span::seconds(1));
  EXPECT_EQ(second.translation_m.count, 100U);
  EXPECT_NEAR(second.translation_m.mean, 0.02, 1e-12);
  EXPECT_NEAR(second.translation_m.max, 0.02, 1e-12);
  const RelativeError ten = relative_error(pairs, Span::metres(10));
  EXPECT_EQ(ten.translation_m.count, 91U);
  EXPECT_NEAR(ten.translation_m.rmse, 0.2, 1e-12);
  EXPECT_EQ(relative_error(pairs, Span::metres(1000)).translation_m.count, 0U);
}

TEST(RelativeError, DoesNotDependOnTheFrameOfTheMap) {
  const Trajectory truth = wander(50);
  Trajectory estimate, moved;
  const SE2d move(4, 5, Angle::degrees(66));
  for (const StampedPose& s : truth) {
    const SE2d off = s.T_map_base.raw().plus({0.1, -0.2, 0.05 * to_seconds(s.time.since_epoch())});
    estimate.push_back({s.time, Transform2<frame::Map, frame::Base>(off)});
    moved.push_back({s.time, Transform2<frame::Map, frame::Base>(move * off)});
  }
  const RelativeError a = relative_error(associate(estimate, truth), Span::seconds(5));
  const RelativeError b = relative_error(associate(moved, truth), Span::seconds(5));
  EXPECT_GT(a.translation_m.mean, 0.1);
  EXPECT_NEAR(a.translation_m.mean, b.translation_m.mean, 1e-9);
  EXPECT_NEAR(a.heading_deg.mean, 0.25 * 180 / M_PI, 1e-6);
}

TEST(PathLength, SumsTheSteps) {
  const Trajectory t = {sample(0, SE2d()), sample(1, SE2d(3, 4, Angle())),
                        sample(2, SE2d(3, 5, Angle()))};
  EXPECT_EQ(path_length_m(t), 6.0);
  EXPECT_EQ(path_length_m({}), 0.0);
}

}  // namespace
}  // namespace wayfare::eval
