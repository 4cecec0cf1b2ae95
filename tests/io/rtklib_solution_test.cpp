// Solutions in RTKLIB's format.
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/text_file.hpp>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <wayfare/core/se3.hpp>
#include "io/text/text.hpp"
#include "support.hpp"

namespace wayfare::io {
namespace {

TEST(RtklibSolution, ColumnsByItsHeading) {
  const std::string text =
      "% program   : RTKPOST\n"
      "%  GPST            latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   "
      "sdu(m)  sdne(m)  sdeu(m)  sdun(m) age(s)  ratio    vn(m/s)    ve(m/s)    vu(m/s)      sdvn  "
      " "
      "  sdve     sdvu    sdvne    sdveu    sdvun\n"
      "2025/07/08 19:34:18.499 40.0966268 -105.1474483 1601.474 1 21 0.0098 0.0099 0.01 -0.001 "
      "0.002 "
      "0.003 0 0 0.01 -0.002 0.009 0.05 0.06 0.07 0 0 0\n";
  const auto fixes = parse_fixes(text, "pos");
  ASSERT_TRUE(fixes) << fixes.error().to_string();
  const GnssFix& fix = fixes->fixes.at(0);
  EXPECT_EQ(fixes->qualities.at(0), 1);
  EXPECT_NEAR(fix.position.latitude.degrees(), 40.0966268, 1e-12);
  EXPECT_EQ(fix.velocity_ned_mps->z(), -0.009);
  EXPECT_NEAR(fix.position_covariance_ned_m2(0, 0), 0.0098 * 0.0098, 1e-15);
  EXPECT_NEAR(fix.position_covariance_ned_m2(0, 1), -1e-6, 1e-15);
  EXPECT_NEAR(fix.position_covariance_ned_m2(1, 2), -4e-6, 1e-15);  // up is minus down
  EXPECT_NEAR(fix.velocity_covariance_ned(2, 2), 0.0049, 1e-15);
  const auto truth = parse_nav(text, "pos");
  ASSERT_TRUE(truth);
  EXPECT_TRUE(truth->has_velocity);
  EXPECT_FALSE(truth->has_attitude);
  EXPECT_EQ(truth->trajectory.at(0).time, fix.time);
}

TEST(RtklibSolution, EarthFixedColumns) {
  const Geodetic at{Angle::degrees(40.0966268), Angle::degrees(-105.1474483), 1601.474};
  const Eigen::Vector3d x = ecef_from_geodetic(at), v_ned(3.0, -4.0, 0.5);
  const Eigen::Matrix3d r = rotation_ecef_ned(at);
  const Eigen::Vector3d v = r * v_ned;
  std::string text =
      "%  GPST x-ecef(m) y-ecef(m) z-ecef(m) Q ns sdx(m) sdy(m) sdz(m) sdxy(m) sdyz(m) sdzx(m) "
      "age(s) ratio vx(m/s) vy(m/s) vz(m/s)\n2025/07/08 19:34:18.499";
  text::append_numbers(text, x);
  text += " 5 9 0.4 0.3 0.2 0.1 -0.05 0.08 0 0";
  text::append_numbers(text, v);
  text += "\n2025/07/08 19:34:19.499 1 2 3 5 9 0.4 0.3 0.2 0.1 -0.05 0.08 0 0 0 0 0\n";
  Eigen::Matrix3d expected;  // the signed roots of the covariances above
  expected << 0.16, 0.01, 0.0064, 0.01, 0.09, -0.0025, 0.0064, -0.0025, 0.04;
  const auto fixes = parse_fixes(text, "pos");
  ASSERT_TRUE(fixes) << fixes.error().to_string();
  ASSERT_EQ(fixes->fixes.size(), 1U);
  ASSERT_EQ(fixes->problems.count(), 1U);  // a position in the Earth's centre
  EXPECT_THAT(fixes->problems.first()[0].to_string(), ::testing::HasSubstr("pos:3: "));
  const GnssFix& fix = fixes->fixes[0];
  EXPECT_LT(ned_from_geodetic(fix.position, at).norm(), 1e-8);
  EXPECT_LT((r * fix.position_covariance_ned_m2 * r.transpose() - expected).norm(), 1e-12);
  EXPECT_LT((*fix.velocity_ned_mps - v_ned).norm(), 1e-9);
  const auto truth = parse_nav(text, "pos");
  ASSERT_TRUE(truth);
  EXPECT_TRUE(truth->has_velocity);
  EXPECT_LT((truth->trajectory.at(0).velocity_ned_mps - v_ned).norm(), 1e-9);
}

TEST(RtklibSolution, RealDrive) {
  WAYFARE_NEEDS_RECORDING(path, "gnss/drive_0708/gnss_1934_sf.pos.gz");
  const auto truth = read_nav(path);
  ASSERT_TRUE(truth) << truth.error().to_string();
  EXPECT_EQ(truth->trajectory.size(), 2197U);  // lines of the file without its heading
  EXPECT_TRUE(truth->problems.empty());
  const Duration lasts = truth->trajectory.back().time - truth->trajectory.front().time;
  EXPECT_EQ(lasts, std::chrono::seconds(549));
}

}  // namespace
}  // namespace wayfare::io
