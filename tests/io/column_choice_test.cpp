// Columns of foreign files by heading or number.

#include <numbers>
#include <string>

#include <wayfare/io/nav_text.hpp>

#include "support.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;

ColumnFormat imu_choices(const std::string& time, const std::string& gx = "Gyro X") {
  ColumnFormat format;
  format.choices = {{"t_ms", time},        {"gx_degps", gx}, {"gy_degps", "3"}, {"gz_degps", "4"},
                    {"ax_g", "Acc X (g)"}, {"ay_g", "6"},    {"az_g", "7"}};
  return format;
}

constexpr const char* kFile =
    "a line of the logger\n"
    "\"Time\",Gyro X,gy,gz,Acc X (g),ay,az,note\n"
    "1000,1,2,3,0.1,0.2,1,x\n"
    "1010,4,5,6,0.1,0.2,1,y\n";

TEST(ColumnChoice, ByHeadingAndByNumber) {
  ColumnFormat format = imu_choices("Time");
  format.skip_lines = 1;
  const auto file = parse_imu(kFile, "x.csv", format);
  ASSERT_TRUE(file) << file.error().to_string();
  ASSERT_EQ(file->samples.size(), 2U);
  EXPECT_EQ(file->samples[0].time, LogTime::from_seconds(1.0));
  EXPECT_DOUBLE_EQ(file->samples[1].angular_rate_radps.x(), 4.0 * std::numbers::pi / 180.0);
  EXPECT_DOUBLE_EQ(file->samples[1].specific_force_mps2.z(), 9.80665);
  ASSERT_EQ(file->columns.size(), 7U);
  EXPECT_EQ(file->columns[1].column, 2U);
  EXPECT_EQ(file->columns[1].heading, "Gyro X");
  EXPECT_EQ(file->columns[1].name, "gx_degps");
}

TEST(ColumnChoice, ByNumberWithoutHeadings) {
  ColumnFormat format;
  format.choices = {{"t_s", "2"}, {"lat_deg", "3"}, {"lon_deg", "1"}, {"h_m", "4"}};
  const auto file = parse_nav("9.5 100 48.5 250 7\n9.6 101 48.6 251 7\n", "x", format);
  ASSERT_TRUE(file) << file.error().to_string();
  ASSERT_EQ(file->trajectory.size(), 2U);
  EXPECT_DOUBLE_EQ(file->trajectory[1].position.latitude.degrees(), 48.6);
  EXPECT_EQ(file->columns.front().heading, "");
}

TEST(ColumnChoice, NamesInTheOrderOfTheFileAreHeadings) {
  ColumnFormat format;
  format.columns = {"lon", "time", "lat", "height"};
  format.choices = {{"t_s", "time"}, {"lat_deg", "lat"}, {"lon_deg", "lon"}, {"h_m", "height"}};
  const auto file = parse_nav("9.5 100 48.5 250\n", "x", format);
  ASSERT_TRUE(file) << file.error().to_string();
  EXPECT_DOUBLE_EQ(file->trajectory[0].position.latitude.degrees(), 48.5);
}

TEST(ColumnChoice, WhatIsMissingIsNamed) {
  ColumnFormat format = imu_choices("Time");
  EXPECT_THAT(parse_imu(kFile, "x.csv", format).error().to_string(),
              HasSubstr("has no column 'Time' for t_ms; it has 5 columns, the first is 'a'"));
  format.skip_lines = 1;
  format.choices[1].column = "Gyro";
  EXPECT_THAT(
      parse_imu(kFile, "x.csv", format).error().to_string(),
      HasSubstr("has no column 'Gyro' for gx_degps; it has 8 columns, the first is 'Time'"));
  format.choices[1].column = "9";
  EXPECT_FALSE(parse_imu(kFile, "x.csv", format));
  format.choices[1].column = "0";
  EXPECT_FALSE(parse_imu(kFile, "x.csv", format));
  format = imu_choices("Time");
  format.skip_lines = 1;
  format.choices[1].name = "gx_dps";
  EXPECT_THAT(parse_imu(kFile, "x.csv", format).error().to_string(),
              HasSubstr("needs one of the units"));
  format.choices[1].name = "lat_deg";
  EXPECT_THAT(parse_imu(kFile, "x.csv", format).error().to_string(),
              HasSubstr("'lat_deg' is not a quantity of such a file"));
  EXPECT_FALSE(parse_imu("", "empty", format));
}

}  // namespace
}  // namespace wayfare::io
