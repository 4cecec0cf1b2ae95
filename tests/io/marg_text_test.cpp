#include <wayfare/io/nav_text.hpp>

#include <cmath>
#include <string>

#include <wayfare/io/text_file.hpp>
#include "support.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;

TEST(MargText, ReadsUnitsAnyOrderAndReference) {
  const Result<MargFile> file = parse_marg(
      "t_ms,mx_nT,my_nT,mz_nT,ax_g,ay_g,az_g,gx_degps,gy_degps,gz_degps,qw,qx,qy,qz,moving\n"
      "20,1000,-2000,3000,0,0,1,180,0,-90,1,0,0,0,0\n"
      "30,nan,,nan,0,0,1,180,0,-90,nan,0,0,0,1\n",
      "m");
  ASSERT_TRUE(file) << file.error().to_string();
  ASSERT_EQ(file->samples.size(), 2U);
  const MargSample& s = file->samples[0];
  EXPECT_EQ(s.time.nanoseconds(), 20'000'000);
  EXPECT_LT((s.magnetic_field_uT - Eigen::Vector3d(1, -2, 3)).norm(), 1e-12);
  EXPECT_LT((s.specific_force_mps2 - Eigen::Vector3d(0, 0, 9.80665)).norm(), 1e-12);
  EXPECT_LT((s.angular_rate_radps - Eigen::Vector3d(M_PI, 0, -M_PI / 2)).norm(), 1e-12);
  EXPECT_TRUE(file->has_magnetometer);
  EXPECT_FALSE(file->samples[1].magnetic_field_uT.allFinite());
  ASSERT_EQ(file->reference.size(), 2U);
  EXPECT_TRUE(file->reference[0].known);
  EXPECT_FALSE(file->reference[1].known);
  EXPECT_EQ(file->moving, (std::vector<bool>{false, true}));
}

TEST(MargText, RoundTrip) {
  MargRecording samples(2);
  samples[0] = {LogTime::from_nanoseconds(-7), {0.1, 1.0 / 3, -2}, {9, 8, 7}, {40.25, -1e-3, 5}};
  samples[1] = samples[0];
  samples[1].time = LogTime::from_nanoseconds(1234567890123456789);
  samples[1].magnetic_field_uT.setConstant(MargSample::kNone);
  const Result<MargFile> file = parse_marg(format_marg(samples), "m");
  ASSERT_TRUE(file) << file.error().to_string();
  ASSERT_EQ(file->samples.size(), 2U);
  EXPECT_EQ(file->samples[0].time, samples[0].time);
  EXPECT_EQ(file->samples[0].angular_rate_radps, samples[0].angular_rate_radps);
  EXPECT_EQ(file->samples[0].specific_force_mps2, samples[0].specific_force_mps2);
  EXPECT_EQ(file->samples[0].magnetic_field_uT, samples[0].magnetic_field_uT);
  EXPECT_EQ(file->samples[1].time, samples[1].time);
  EXPECT_TRUE(file->samples[1].magnetic_field_uT.array().isNaN().all());
  EXPECT_TRUE(file->reference.empty());
  EXPECT_EQ(file->moving, (std::vector<bool>{true, true}));
}

TEST(MargText, SixAxesHaveNoMagnetometer) {
  const Result<MargFile> file =
      parse_marg("t_s gx_radps gy_radps gz_radps ax_g ay_g az_g\n1 0 0 0 0 0 1\n", "m");
  ASSERT_TRUE(file) << file.error().to_string();
  EXPECT_FALSE(file->has_magnetometer);
  EXPECT_EQ(format_marg(file->samples).find("mx"), std::string::npos);
}

TEST(MargText, ReadsAirPressure) {
  const std::string names = "t_s,gx_radps,gy_radps,gz_radps,ax_g,ay_g,az_g,";
  for (const auto& [column, value] : {std::pair("p_hPa", "1013.25"),
                                      {"p_mbar", "1013.25"},
                                      {"p_kPa", "101.325"},
                                      {"p [Pa]", "101325"}}) {
    const auto file =
        parse_marg(names + column + "\n1,0,0,0,0,0,1," + value + "\n2,0,0,0,0,0,1,nan\n", "m");
    ASSERT_TRUE(file) << file.error().to_string();
    ASSERT_EQ(file->pressure_Pa.size(), 2U);
    EXPECT_NEAR(file->pressure_Pa[0], 101325.0, 1e-6);
    EXPECT_TRUE(std::isnan(file->pressure_Pa[1]));
  }
  const auto without = parse_marg(names.substr(0, names.size() - 1) + "\n1,0,0,0,0,0,1\n", "m");
  ASSERT_TRUE(without);
  EXPECT_TRUE(without->pressure_Pa.empty());
}

TEST(MargText, NamesMissingColumns) {
  const auto message = [](const char* text) {
    const Result<MargFile> file = parse_marg(text, "m");
    return file ? std::string("taken") : file.error().message;
  };
  EXPECT_THAT(message("t_s gx_radps gy_radps gz_radps\n1 0 0 0\n"), HasSubstr("ax, ay, az"));
  EXPECT_THAT(message("t_s gx_radps gy_radps gz_radps ax_g ay_g az_g mx_uT\n1 0 0 0 0 0 1 2\n"),
              HasSubstr("my, mz"));
  EXPECT_THAT(message("t_s gx_radps gy_radps gz_radps ax_g ay_g az_g qw\n1 0 0 0 0 0 1 2\n"),
              HasSubstr("qx, qy, qz"));
  EXPECT_THAT(message("t_s gx_radps gy_radps gz_radps ax_g ay_g az_lb\n1 0 0 0 0 0 1\n"),
              HasSubstr("units"));
  EXPECT_THAT(message("t_s gx_radps gy_radps gz_radps ax_g ay_g az_g\n"), HasSubstr("no sample"));
  EXPECT_THAT(message(""), HasSubstr("names columns"));
}

TEST(MargText, BinaryTableWithNamesFromTheCaller) {
  const std::vector<float> values = {0, 0, 1, 0, 0, 9.75F, 0, 0, 2, 0, 0, 9.5F};
  const std::string bytes = format_float_table(values, 6);
  MargFormat format;
  format.columns.columns = {"gx_radps", "gy_radps", "gz_radps", "ax_mps2", "ay_mps2", "az_mps2"};
  format.period_s = 0.007;
  const Result<MargFile> file = parse_marg(bytes, "b", format);
  ASSERT_TRUE(file) << file.error().to_string();
  ASSERT_EQ(file->samples.size(), 2U);
  EXPECT_EQ(file->samples[1].time.nanoseconds(), 7'000'000);
  EXPECT_EQ(file->samples[1].angular_rate_radps.z(), 2.0);
  EXPECT_EQ(file->samples[0].specific_force_mps2.z(), 9.75);
  format.columns.columns.pop_back();
  const Result<MargFile> short_names = parse_marg(bytes, "b", format);
  ASSERT_FALSE(short_names);
  EXPECT_THAT(short_names.error().message, HasSubstr("6 columns"));
}

}  // namespace
}  // namespace wayfare::io
