// Columns of inertial samples, ranges, fixes and reference trajectories. Expected values are
// derived by hand from the units' definitions.
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

using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;

TEST(ImuText, ColumnsInAnyOrderAndUnit) {
  const auto file = parse_imu(
      "ax_g, ay_mg, az [m/s^2], t_ms, gx_degps, gy_radps, gz(deg/s), temperature\n"
      "1, 500, 9.5, 261906.25, 180, 0.5, -90, 21\n",
      "imu");
  ASSERT_TRUE(file) << file.error().to_string();
  ASSERT_EQ(file->samples.size(), 1U);
  const ImuSample& s = file->samples[0];
  EXPECT_EQ(s.time.nanoseconds(), 261'906'250'000);
  EXPECT_NEAR(s.specific_force_mps2.x(), 9.80665, 1e-12);
  EXPECT_NEAR(s.specific_force_mps2.y(), 4.903325, 1e-12);
  EXPECT_EQ(s.specific_force_mps2.z(), 9.5);
  EXPECT_NEAR(s.angular_rate_radps.x(), std::numbers::pi, 1e-12);
  EXPECT_EQ(s.angular_rate_radps.y(), 0.5);
  EXPECT_NEAR(s.angular_rate_radps.z(), -std::numbers::pi / 2, 1e-12);
}

TEST(ImuText, RoundTripIsBitExact) {
  std::vector<ImuSample> samples;
  for (int i = 0; i < 200; ++i) {
    const double v = std::sin(i * 12.9898) * std::exp(i * 0.3 - 30.0);
    samples.push_back({LogTime::from_nanoseconds(1435606458499000001 + 10'000'003 * i),
                       {v, -v / 3.0, 1.0 / (v + 2.0)},
                       {9.8 + v, v * v, -0.1 * v}});
  }
  const auto file = parse_imu(format_imu(samples), "imu");
  ASSERT_TRUE(file);
  EXPECT_TRUE(file->problems.empty());
  ASSERT_EQ(file->samples.size(), samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(file->samples[i].time, samples[i].time);
    EXPECT_EQ(file->samples[i].angular_rate_radps, samples[i].angular_rate_radps);
    EXPECT_EQ(file->samples[i].specific_force_mps2, samples[i].specific_force_mps2);
  }
}

TEST(ImuText, DescribedForeignColumns) {
  ColumnFormat acc{{"t_ns", "ax_mps2", "ay_mps2", "az_mps2"}, 3};
  const std::string text =
      "Sensor: X\nVendor: Y\nTimestampAcc [ns]; AccX [m/s^2]; AccY [m/s^2]; AccZ [m/s^2]\n"
      "1028164587713590;0.0599;9.3999;1.4342;\n";
  const auto file = parse_imu(text, "acc", acc);
  ASSERT_TRUE(file) << file.error().to_string();
  EXPECT_TRUE(file->has_accelerometer);
  EXPECT_FALSE(file->has_gyro);
  EXPECT_EQ(file->samples.at(0).time.nanoseconds(), 1028164587713590);
  EXPECT_EQ(file->samples.at(0).specific_force_mps2.y(), 9.3999);
}

TEST(ImuText, OnlyDamagedLinesAreSkippedAndReported) {
  const auto file = parse_imu(
      "# t_s gx_radps gy_radps gz_radps ax_mps2 ay_mps2 az_mps2\n"
      "1 0 0 0 0 0 -9.8\n"
      "1.01 0 0 nan 0 0 -9.8\n"
      "1.02 0 0 0 0 0\n"
      "1.03 0 0 x 0 0 -9.8\n"
      "later 0 0 0 0 0 -9.8\n"
      "1.04 0 0 0 0 0 -9.8 7\n"
      "\n# a remark\n"
      "1.05 0 0 0 0 0 1e999\n"
      "1.06 0 0 0 0 0 -9.7\n",
      "imu");
  ASSERT_TRUE(file);
  ASSERT_EQ(file->samples.size(), 2U);
  EXPECT_EQ(file->samples[1].specific_force_mps2.z(), -9.7);
  ASSERT_EQ(file->problems.count(), 6U);
  std::vector<std::size_t> lines;
  for (const Error& e : file->problems.first()) lines.push_back(e.line);
  EXPECT_THAT(lines, ::testing::ElementsAre(3, 4, 5, 6, 7, 10));
  EXPECT_THAT(file->problems.first()[1].message, HasSubstr("expected 7 fields, found 6"));
}

TEST(ImuText, RejectsInvalidColumns) {
  const auto message = [](const std::string& text) {
    const auto file = parse_imu(text, "imu");
    return file ? std::string() : file.error().to_string();
  };
  EXPECT_THAT(message(""), HasSubstr("contains no line that names columns"));
  EXPECT_THAT(message("1 2 3 4 5 6 7\n"), HasSubstr("imu:1: expected a line that names"));
  EXPECT_THAT(message("t_s gx_radps gy_radps gz_radps\n"),
              HasSubstr("contains no inertial sample"));
  EXPECT_THAT(message("t_s gx_radps gy_radps ax_g ay_g az_g\n1 2 3 4 5 6\n"),
              HasSubstr("no column for gz"));
  EXPECT_THAT(message("t_s gx_rpm gy_rpm gz_rpm\n1 2 3 4\n"),
              HasSubstr("radps, rad/s, degps, deg/s"));
  EXPECT_THAT(message("t_s t_ms gx_radps gy_radps gz_radps\n1 1 2 3 4\n"),
              HasSubstr("second time column"));
  EXPECT_THAT(message("t_s gx_radps gx_radps gz_radps\n1 1 2 3\n"), HasSubstr("twice"));
  EXPECT_THAT(message("tow_s gx_radps gy_radps gz_radps\n1 2 3 4\n"), HasSubstr("gives the time"));
  EXPECT_THAT(message("t_s temperature\n1 2\n"), HasSubstr("no column for gx, gy, gz"));
}

TEST(ImuText, PartsAreMergedAtTheGyrosTimes) {
  const auto at = [](std::int64_t ms, double g, double a) {
    return ImuSample{LogTime::from_nanoseconds(ms * 1'000'000), {g, 0, 0}, {a, 0, 0}};
  };
  const std::vector gyro = {at(5, 1, 0), at(10, 2, 0), at(15, 3, 0), at(700, 4, 0), at(2000, 5, 0)};
  const std::vector acc = {at(10, 0, 1), at(20, 0, 3), at(1500, 0, 7)};
  const std::vector<ImuSample> merged = merge_imu_parts(gyro, acc);
  ASSERT_EQ(merged.size(),
            2U);  // before the first, in a gap of 1.48 s, and after the last: dropped
  EXPECT_EQ(merged[0].specific_force_mps2.x(), 1.0);
  EXPECT_EQ(merged[1].angular_rate_radps.x(), 3.0);
  EXPECT_NEAR(merged[1].specific_force_mps2.x(), 2.0, 1e-12);
}

TEST(ColumnTimes, EveryKindIsConvertedToGpsTime) {
  // 2025-07-08 19:34:18.499 GPS time: week 2374, Tuesday, 243258.499 s of the week.
  const std::int64_t expected = (2374LL * 604800 + 243258) * 1'000'000'000 + 499'000'000;
  const std::vector<std::pair<std::string, std::string>> times = {
      {"week tow_s", "2374 243258.499"},
      {"date clock", "2025/07/08 19:34:18.499"},
      {"utc_date utc_clock", "2025-07-08 19:34:00.499"},
      {"t_s", "1436038458.499"},
      {"unixgps_s", "1752003258.499"},
      {"utc_ms", "1752003240499"}};
  for (const auto& [names, values] : times) {
    const auto file = parse_nav(names + " lat_deg lon_deg h_m\n" + values + " 1 2 3\n", names);
    ASSERT_TRUE(file) << names << ": " << file.error().to_string();
    EXPECT_EQ(file->trajectory.at(0).time.nanoseconds(), expected) << names;
  }
}

TEST(ColumnTimes, InvalidTimesAreRejected) {
  const std::vector<std::pair<std::string, std::string>> times = {
      {"week tow_s", "-1 1"},
      {"week tow_s", "2.5 1"},
      {"date clock", "2025/02/30 1:1:1"},
      {"date clock", "2025/02 1:1:1"},
      {"date clock", "2025/02/03 24:1:1"},
      {"date clock", "2025/02/03 1:1"},
      {"t_s", "1e30"},
      {"t_ns", "99999999999999999999"},
      {"utc_s", "nan"}};
  for (const auto& [names, values] : times)
    EXPECT_FALSE(parse_nav(names + " lat_deg lon_deg h_m\n" + values + " 1 2 3\n", "t")) << values;
}

TEST(RangesText, RoundTrip) {
  std::vector<RangeEpoch> epochs(2);
  for (std::size_t e = 0; e < 2; ++e) {
    epochs[e].time =
        LogTime::from_nanoseconds(1435606458'000'000'000 + 250'000'001 * std::int64_t(e));
    for (std::uint8_t n = 1; n < 5; ++n) {
      CorrectedRange r;
      r.satellite = {static_cast<GnssSystem>(n - 1), static_cast<std::uint8_t>(9 * n)};
      r.position_ecef_m = {2.6e7 / n, 1.0 / 3.0, -1e-9};
      r.velocity_ecef_mps = {-3000.1, 1.0 * n, 0.5};
      r.range_m = 2.1e7 + n / 7.0;
      r.range_rate_mps = n == 2 ? std::nan("") : -700.0 / n;
      r.range_sigma_m = 2.0;
      epochs[e].satellites.push_back(r);
    }
  }
  const auto file = parse_ranges(format_ranges(epochs), "ranges");
  ASSERT_TRUE(file) << file.error().to_string();
  ASSERT_EQ(file->epochs.size(), 2U);
  for (std::size_t e = 0; e < 2; ++e) {
    EXPECT_EQ(file->epochs[e].time, epochs[e].time);
    ASSERT_EQ(file->epochs[e].satellites.size(), 4U);
    for (std::size_t s = 0; s < 4; ++s) {
      const CorrectedRange &a = file->epochs[e].satellites[s], &b = epochs[e].satellites[s];
      EXPECT_EQ(a.satellite, b.satellite);
      EXPECT_EQ(a.position_ecef_m, b.position_ecef_m);
      EXPECT_EQ(a.velocity_ecef_mps, b.velocity_ecef_mps);
      EXPECT_EQ(a.range_m, b.range_m);
      EXPECT_EQ(std::isnan(a.range_rate_mps), s == 1);
      EXPECT_EQ(a.range_sigma_m, b.range_sigma_m);
      EXPECT_TRUE(std::isnan(a.cn0_dbhz));
    }
  }
}

TEST(RangesText, PhasesAreWrittenWhereThereAreAny) {
  std::vector<RangeEpoch> epochs(1);
  epochs[0].satellites.resize(2);
  epochs[0].satellites[0].satellite = {GnssSystem::gps, 1};
  epochs[0].satellites[1].satellite = {GnssSystem::gps, 2};
  EXPECT_EQ(format_ranges(epochs).find("phase"), std::string::npos);
  CorrectedRange& s = epochs[0].satellites[1];
  s.phase_m = 2.1234567891234e7, s.phase_sigma_m = 0.004, s.phase_interrupted = true;
  const auto file = parse_ranges(format_ranges(epochs), "ranges");
  ASSERT_TRUE(file) << file.error().to_string();
  const auto& back = file->epochs[0].satellites;
  EXPECT_TRUE(std::isnan(back[0].phase_m));
  EXPECT_FALSE(back[0].phase_interrupted);
  EXPECT_EQ(back[1].phase_m, s.phase_m);
  EXPECT_EQ(back[1].phase_sigma_m, s.phase_sigma_m);
  EXPECT_TRUE(back[1].phase_interrupted);
}

TEST(WheelsText, RoundTripAndBadLines) {
  const std::vector<WheelSpeed> readings = {{LogTime::from_seconds(1.5), 12.345678901234567},
                                            {LogTime::from_seconds(1.6), -0.1}};
  const auto file = parse_wheels(format_wheels(readings), "wheels");
  ASSERT_TRUE(file) << file.error().to_string();
  ASSERT_EQ(file->readings.size(), 2U);
  EXPECT_EQ(file->readings[0].time, readings[0].time);
  EXPECT_EQ(file->readings[0].speed_mps, readings[0].speed_mps);
  EXPECT_EQ(file->readings[1].speed_mps, readings[1].speed_mps);
  const auto kmh = parse_wheels("t_s speed_kmh\n1 36\n2 nan\n3 inf\n4 x\n5 1e9\n", "wheels");
  ASSERT_TRUE(kmh) << kmh.error().to_string();
  ASSERT_EQ(kmh->readings.size(), 1U);
  EXPECT_DOUBLE_EQ(kmh->readings[0].speed_mps, 10.0);
  EXPECT_EQ(kmh->problems.count(), 4U);
  EXPECT_EQ(kmh->problems.first().front().line, 3U);
  const auto none = parse_wheels("t_s velocity\n1 2\n", "wheels.csv");
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().to_string().find("wheels.csv"), std::string::npos);
}

TEST(RangesText, OneBadSatelliteAffectsItsLineOnly) {
  const std::string names = "t_s sat x_m y_m z_m vx_mps vy_mps vz_mps range_m range_sigma_m\n";
  const auto file = parse_ranges(names +
                                     "1 G01 2e7 0 0 0 0 0 2e7 2\n"
                                     "1 X01 2e7 0 0 0 0 0 2e7 2\n"
                                     "1 G02 nan 0 0 0 0 0 2e7 2\n"
                                     "1 G03 2e7 0 0 0 0 0 2e7 0\n"
                                     "1 G01 2e7 0 0 0 0 0 2e7 2\n"
                                     "1 E300 2e7 0 0 0 0 0 2e7 2\n"
                                     "1 E03 2e7 0 0 0 0 0 nan 2\n",
                                 "ranges");
  ASSERT_TRUE(file);
  ASSERT_EQ(file->epochs.size(), 1U);
  EXPECT_EQ(file->epochs[0].satellites.size(), 2U);
  EXPECT_EQ(file->problems.count(), 5U);
}

TEST(FixText, RoundTrip) {
  std::vector<GnssFix> fixes(2);
  fixes[0].time = LogTime::from_nanoseconds(5);
  fixes[0].position = {Angle::degrees(48.5), Angle::degrees(-9.25), 301.5};
  const Eigen::Matrix3d root = (Eigen::Matrix3d() << 3, 0, 0, 0.4, 2, 0, -0.6, 0.3, 5).finished();
  fixes[0].position_covariance_ned_m2 = root * root.transpose();
  fixes[0].velocity_ned_mps = Eigen::Vector3d(1.5, -2.5, 0.25);
  fixes[1].time = LogTime::from_nanoseconds(7);
  const auto file = parse_fixes(format_fixes(fixes), "fixes");
  ASSERT_TRUE(file) << file.error().to_string();
  ASSERT_EQ(file->fixes.size(), 2U);
  const GnssFix& back = file->fixes[0];
  EXPECT_EQ(back.time, fixes[0].time);
  EXPECT_LT(ned_from_geodetic(back.position, fixes[0].position).norm(), 1e-8);
  EXPECT_LT((back.position_covariance_ned_m2 - fixes[0].position_covariance_ned_m2).norm(), 1e-12);
  EXPECT_EQ(back.velocity_ned_mps, fixes[0].velocity_ned_mps);
  EXPECT_FALSE(file->fixes[1].velocity_ned_mps);
}

TEST(FixText, PhonesSpeedAndCourse) {
  const ColumnFormat phone{{"t_ns", "utc_ms", "lat_deg", "lon_deg", "h_m", "speed_mps",
                            "course_deg", "sh_m", "sv_h_m", "sspeed_mps", "-"},
                           1};
  EXPECT_FALSE(parse_fixes("heading\n1;2;3;4;5;6;7;8;9;10;11;\n", "two times", phone));
  ColumnFormat one = phone;
  one.columns[0] = "-";
  const auto file = parse_fixes(
      "TimestampGNSS [ns]; UTC time [ms]; ...\n"
      "1028167800701097;1605968876458;48.79;9.228;299.63;10;90;6.0;25.2;0.25;180;\n",
      "phone", one);
  ASSERT_TRUE(file) << file.error().to_string();
  const GnssFix& fix = file->fixes.at(0);
  EXPECT_EQ(fix.time.nanoseconds(), (1605968876'458LL - 315964800'000LL + 18'000LL) * 1'000'000);
  ASSERT_TRUE(fix.velocity_ned_mps);
  EXPECT_NEAR(fix.velocity_ned_mps->x(), 0.0, 1e-12);
  EXPECT_NEAR(fix.velocity_ned_mps->y(), 10.0, 1e-12);
  EXPECT_NEAR(fix.position_covariance_ned_m2(0, 0), 18.0, 1e-9);
  EXPECT_NEAR(fix.position_covariance_ned_m2(2, 2), 25.2 * 25.2, 1e-9);
}

TEST(NavText, RoundTrip) {
  NavState state;
  state.time = LogTime::from_nanoseconds(1435606458499000001);
  state.position = {Angle::degrees(-33.1), Angle::degrees(151.7), -5.25};
  state.velocity_ned_mps = {1, -2, 0.5};
  state.q_nb = rotation_from_roll_pitch_yaw({0.1, -0.2, 3.0});
  const auto file = parse_nav(format_nav(std::vector{state}), "truth");
  ASSERT_TRUE(file) << file.error().to_string();
  EXPECT_TRUE(file->has_velocity && file->has_attitude);
  const NavState& back = file->trajectory.at(0);
  EXPECT_EQ(back.time, state.time);
  EXPECT_LT(ned_from_geodetic(back.position, state.position).norm(), 1e-8);
  EXPECT_EQ(back.velocity_ned_mps, state.velocity_ned_mps);
  EXPECT_LT(back.q_nb.minus(state.q_nb).norm(), 1e-14);
}

TEST(NavText, InvalidPositionsAreSkipped) {
  const auto file = parse_nav(
      "week,tow_s,lat_deg,lon_deg,h_m\n2051,1,91,0,0\n2051,2,0,400,0\n2051,3,,1,2\n2051,4,1,2,3\n",
      "t");
  ASSERT_TRUE(file);
  EXPECT_EQ(file->trajectory.size(), 1U);
  EXPECT_EQ(file->problems.count(), 3U);
}

TEST(RollPitchYaw, MatchesTheClassicalSequence) {
  // A vehicle that heads east (yaw 90°), pitches up by 30° and then rolls right by 90° has its nose
  // east and up, its right side down (and forward by the pitch).
  const SO3d q = rotation_from_roll_pitch_yaw(Eigen::Vector3d(90, 30, 90) * kDegree);
  const Eigen::Vector3d nose = q * Eigen::Vector3d::UnitX(), right = q * Eigen::Vector3d::UnitY();
  EXPECT_LT((nose - Eigen::Vector3d(0, std::sqrt(0.75), -0.5)).norm(), 1e-14);
  EXPECT_LT((right - Eigen::Vector3d(0, 0.5, std::sqrt(0.75))).norm(), 1e-14);
  for (double yaw = -3.1; yaw < 3.14; yaw += 0.61) {
    const Eigen::Vector3d angles(2.0 * std::sin(yaw * 5.0), 1.5 * std::cos(yaw * 3.0), yaw);
    EXPECT_LT((roll_pitch_yaw_rad(rotation_from_roll_pitch_yaw(angles)) - angles).norm(), 1e-13);
  }
}

}  // namespace
}  // namespace wayfare::io
