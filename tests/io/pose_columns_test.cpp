// Trajectories in the plane, as columns or TUM text.

#include <string>

#include <gmock/gmock.h>

#include <wayfare/io/tum.hpp>

namespace wayfare::io {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

PoseFile poses_in(const std::string& text) {
  const auto file = parse_poses(text, "truth");
  EXPECT_TRUE(file.has_value()) << file.error().to_string();
  return file ? *file : PoseFile{};
}

std::string pose_fault(const std::string& text) {
  const auto file = parse_poses(text, "truth.csv");
  if (!file) return file.error().to_string();
  return file->problems.empty() ? "" : file->problems.first().front().to_string();
}

void expect_turned(const PoseFile& file) {
  ASSERT_EQ(file.trajectory.size(), 2U);
  EXPECT_TRUE(file.has_heading);
  EXPECT_EQ(file.trajectory[1].time, LogTime::from_seconds(1.5));
  EXPECT_EQ(file.trajectory[1].T_map_base.raw().x(), 2.0);
  EXPECT_EQ(file.trajectory[1].T_map_base.raw().y(), -1.0);
  EXPECT_NEAR(file.trajectory[1].T_map_base.raw().heading().degrees(), 90.0, 1e-6);
}

TEST(PoseColumns, HeightsAreReadFromColumnsThatHaveThemAndFromTum) {
  EXPECT_THAT(poses_in("t_s,x_m,y_m,z_m\n0,1,2,3\n4,5,6,-7\n").heights_m, ElementsAre(3.0, -7.0));
  EXPECT_THAT(poses_in("0 1 2 3 0 0 0 1\n4 5 6 -7 0 0 0 1\n").heights_m, ElementsAre(3.0, -7.0));
  EXPECT_THAT(poses_in("t_s,x_m,y_m\n0,1,2\n4,5,6\n").heights_m, IsEmpty());
  const PoseFile file = poses_in("t_s,x_m,y_m,z_m\n0,1,2,nan\n4,5,6,-7\n");
  EXPECT_THAT(file.heights_m, ElementsAre(-7.0));
  EXPECT_EQ(file.trajectory.size(), 1U);
}

TEST(PoseColumns, OneTrajectoryInEveryForm) {
  expect_turned(poses_in("1.0 0 0 0 0 0 0 1\n1.5 2 -1 0.3 0 0 0.70710678 0.70710678\n"));
  expect_turned(
      poses_in("# t x y z qx qy qz qw\n1 0 0 0 0 0 0 1\n1.5 2 -1 9 0 0 0.70710678 0.70710678"));
  expect_turned(poses_in("t_s,x_m,y_m,heading_deg\n1,0,0,0\n1.5,2,-1,90\n"));
  expect_turned(
      poses_in("# t [ms]; y [cm]; x [m]; yaw [rad]\n1000;0;0;0\n1500;-100;2;1.570796327\n"));
  expect_turned(
      poses_in("t_s x_m y_m z_m qx qy qz qw\n1 0 0 0 0 0 0 1\n1.5 2 -1 0 0 0 .70710678 .70710678"));
}

TEST(PoseColumns, PointsHaveNoHeading) {
  const PoseFile file = poses_in("t_s,x_m,y_m\n0,1,2\n4,5,6\n");
  EXPECT_FALSE(file.has_heading);
  EXPECT_EQ(file.trajectory[1].T_map_base.raw().heading().degrees(), 0.0);
}

TEST(PoseColumns, NamesWhatIsWrong) {
  EXPECT_THAT(pose_fault("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 1\n"),
              HasSubstr("truth.csv:2: fewer than 8 numbers"));
  EXPECT_THAT(pose_fault("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1 7\n"), HasSubstr("more than 8 numbers"));
  EXPECT_THAT(pose_fault("1 0 0 0 0 0 0 1\n2 nan 0 0 0 0 0 1\n"),
              HasSubstr("not a finite number: 'nan'"));
  EXPECT_THAT(pose_fault("1 0 0 0 0 0 0 0\n"), HasSubstr("unit length"));
  EXPECT_THAT(pose_fault("t_s,x_m,y_m\n0,1,2\n1,2\n"),
              HasSubstr("truth.csv:3: expected 3 fields, found 2"));
  EXPECT_THAT(pose_fault("t_s,x_m,y_m\n0,1,2\n1,nan,2\n"),
              HasSubstr("truth.csv:3: not a finite pose"));
  EXPECT_THAT(pose_fault("t_s,x_m,yaw_deg,y_m\n0,1,0,2\n1,1,,2\n"), HasSubstr("not a finite pose"));
  EXPECT_THAT(pose_fault("t_s,x_m\n0,1\n"), HasSubstr("has no column for y"));
  EXPECT_THAT(pose_fault("t_s,x_m,y_m,qx,qw\n0,1,2,0,1\n"), HasSubstr("has no column for qy, qz"));
  EXPECT_THAT(pose_fault("t_s,x_deg,y_m\n0,1,2\n"), HasSubstr("needs one of the units"));
  EXPECT_THAT(pose_fault("0,1,2\n"), HasSubstr("names the columns"));
  EXPECT_THAT(pose_fault(""), HasSubstr("contains no pose"));
  EXPECT_THAT(pose_fault("t_s,x_m,y_m\n"), HasSubstr("contains no pose"));
}

}  // namespace
}  // namespace wayfare::io
