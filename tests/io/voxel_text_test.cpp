#include <wayfare/io/map_image.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support.hpp"

namespace wayfare::io {
namespace {

TEST(VoxelText, ReadsBothForms) {
  const auto read = parse_points("# map\n(-0.075 0.5 -1e-1)\r\n\n1.5,2,3\n", "m");
  ASSERT_TRUE(read.has_value());
  ASSERT_EQ(read->points_m.size(), 2U);
  EXPECT_EQ(read->points_m[0], Eigen::Vector3d(-0.075, 0.5, -0.1));
  EXPECT_EQ(read->points_m[1], Eigen::Vector3d(1.5, 2.0, 3.0));
  EXPECT_TRUE(read->problems.empty());
}

TEST(VoxelText, MalformedLinesAreReportedAndSkipped) {
  const auto read = parse_points("1 2\n1 2 3\n1 2 nan\n1 2 3 4\n(a b c)\n", "m");
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->points_m.size(), 1U);
  ASSERT_EQ(read->problems.count(), 4U);
  EXPECT_EQ(read->problems.first()[1].line, 3U);
  EXPECT_THAT(read->problems.first()[2].to_string(), ::testing::HasSubstr("m:4: more than three"));
  EXPECT_FALSE(parse_points("# nothing\n", "m").has_value());
  EXPECT_FALSE(read_points("/no/such/file").has_value());
}

TEST(VoxelText, RealMap) {
  WAYFARE_NEEDS_RECORDING(path,
                          "radar/coloradar_rmap/data/maps/ec_hallways_run0_lidar_filtered.txt.gz");
  const auto read = read_points(path);
  ASSERT_TRUE(read.has_value());
  EXPECT_TRUE(read->problems.empty());
  EXPECT_EQ(read->points_m.size(), 174991U);  // lines of the file
}

}  // namespace
}  // namespace wayfare::io
