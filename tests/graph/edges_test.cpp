#include <wayfare/graph/edges.hpp>

#include <gtest/gtest.h>

#include <wayfare/testing/edge_laws.hpp>

namespace wayfare {
namespace {

using testing::EdgeLaws;

TEST(Edges, KeepTheLaws) {
  const SE2d planar(1.0, 2.0, Angle::degrees(30));
  const SE3d spatial =
      SE3d::exp((Eigen::Matrix<double, 6, 1>() << 1, -2, 3, 0.4, 0.2, -0.3).finished());
  //! [laws]
  EdgeLaws<Prior<SE2d>>{{Prior<SE2d>{planar}}, 0.5}.check();
  EdgeLaws<Prior<SE3d>>{{Prior<SE3d>{spatial}}, 0.5}.check();
  EdgeLaws<Prior<Eigen::Vector2d>>{{Prior<Eigen::Vector2d>{Eigen::Vector2d(1.0, -2.0)}}}.check();
  EdgeLaws<Between<SE2d>>{{Between<SE2d>{planar}}, 0.5}.check();
  EdgeLaws<Between<SE3d>>{{Between<SE3d>{spatial}}, 0.5}.check();
  EdgeLaws<LandmarkPosition<SE2d>>{{LandmarkPosition<SE2d>{Eigen::Vector2d(3, -1)}}}.check();
  EdgeLaws<LandmarkPosition<SE3d>>{{LandmarkPosition<SE3d>{Eigen::Vector3d(3, -1, 2)}}}.check();
  //! [laws]
  // Near the landmark the bearing's third derivative is large, and differences are inaccurate.
  EdgeLaws<BearingRange>{{BearingRange{Angle::degrees(20), 4.0}}, 2.0, 50, 1e-4}.check();
  EdgeLaws<RangeTo<SE2d>>{{RangeTo<SE2d>{3.0}}}.check();
  EdgeLaws<RangeTo<SE3d>>{{RangeTo<SE3d>{3.0}}}.check();
  EdgeLaws<PositionOf<SE2d>>{{PositionOf<SE2d>{{1, 2}, Eigen::Matrix2d::Identity(), {0.3, 0.1}}}}
      .check();
  EdgeLaws<PositionOf<SE3d>>{
      {PositionOf<SE3d>{{1, 2, 3}, Eigen::Matrix3d::Identity(), {0.3, 0.1, 0.2}}}}
      .check();
  EdgeLaws<PoseOf<SE2d>>{
      {PoseOf<SE2d>{planar, Eigen::Matrix3d::Identity(), SE2d(0.3, 0.1, Angle::degrees(40))}}, 0.5}
      .check();
  EdgeLaws<PoseOf<SE3d>>{{PoseOf<SE3d>{spatial, SquareOf<SE3d>::Identity(),
                                       SE3d({0.3, 0.1, 0.2}, spatial.rotation())}},
                         0.5}
      .check();
  EdgeLaws<Robust<LandmarkPosition<SE2d>>>{{Robust<LandmarkPosition<SE2d>>{}}}.check();
}

TEST(Edges, AreZeroWhereTheMeasurementIsExact) {
  const SE2d pose(1.0, 2.0, Angle::degrees(30)), other = pose * SE2d(2.0, 0.5, Angle::degrees(-10));
  const Eigen::Vector2d landmark(4.0, 7.0), seen = pose.inverse() * landmark;
  EXPECT_LT(Between<SE2d>{pose.inverse() * other}.error(pose, other).norm(), 1e-14);
  EXPECT_LT(Prior<SE2d>{pose}.error(pose).norm(), 1e-14);
  EXPECT_LT(LandmarkPosition<SE2d>{seen}.error(pose, landmark).norm(), 1e-14);
  const Angle bearing = Angle::radians(std::atan2(seen.y(), seen.x()));
  EXPECT_LT((BearingRange{bearing, seen.norm()}).error(pose, landmark).norm(), 1e-14);
  EXPECT_LT(RangeTo<SE2d>{seen.norm()}.error(pose, landmark).norm(), 1e-14);
  const Eigen::Vector2d antenna(0.4, -0.2);
  EXPECT_LT(
      (PositionOf<SE2d>{pose * antenna, Eigen::Matrix2d::Identity(), antenna}).error(pose).norm(),
      1e-14);
  const SE2d camera(0.4, -0.2, Angle::degrees(90));
  EXPECT_LT((PoseOf<SE2d>{pose * camera, Eigen::Matrix3d::Identity(), camera}).error(pose).norm(),
            1e-14);
}

// The camera looks to the left, 0.5 m ahead of the robot's origin. Measured one metre further along
// the robot's x axis than it is: one metre to the camera's right, so the truth is to its left.
TEST(Edges, APoseIsComparedInTheMeasuredFrame) {
  const SE2d camera(0.5, 0.0, Angle::degrees(90));
  const PoseOf<SE2d> edge{SE2d(1.5, 0.0, Angle::degrees(90)), Eigen::Matrix3d::Identity(), camera};
  EXPECT_TRUE(edge.error(SE2d()).isApprox(Eigen::Vector3d(0.0, 1.0, 0.0), 1e-12));
}

// The error of a bearing is the short way round.
TEST(Edges, BearingsAreComparedAcrossHalfATurn) {
  const BearingRange edge{Angle::degrees(179), 1.0};
  const Eigen::Vector2d behind(-1.0, -std::tan(std::numbers::pi / 180.0));  // at −179°
  EXPECT_NEAR(edge.error(SE2d(), behind)[0], 2.0 * std::numbers::pi / 180.0, 1e-12);
}

// At the landmark itself the direction is undefined; nothing may become NaN.
TEST(Edges, AreFiniteAtTheLandmarkItself) {
  EdgeJacobians<2, BearingRange::Variables> seen;
  EXPECT_TRUE(
      (BearingRange{Angle(), 1.0}).linearise(SE2d(), Eigen::Vector2d::Zero(), seen).allFinite());
  EXPECT_TRUE(std::get<0>(seen.by).allFinite() && std::get<1>(seen.by).allFinite());
  EdgeJacobians<1, RangeTo<SE3d>::Variables> range;
  EXPECT_TRUE(RangeTo<SE3d>{1.0}.linearise(SE3d(), Eigen::Vector3d::Zero(), range).allFinite());
  EXPECT_TRUE(std::get<0>(range.by).allFinite() && std::get<1>(range.by).allFinite());
}

}  // namespace
}  // namespace wayfare
