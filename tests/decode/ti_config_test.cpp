#include <wayfare/decode/ti_decoder.hpp>

#include "captures.hpp"

namespace wayfare::decode {
namespace {

const std::string kGood = R"(% a comment
sensorStop
dfeDataOutputMode 1
channelCfg 15 5 0
adcCfg 2 1
profileCfg 0 77 429 7 57.14 0 0 70 1 256 5209 0 0 30
chirpCfg 0 0 0 0 0 0 0 1
chirpCfg 1 1 0 0 0 0 0 4
frameCfg 0 1 16 0 100 1 0
cfarCfg -1 0 2 8 4 3 0 9 0
clutterRemoval -1 1
aoaFovCfg -1 -80 70 -20 30
cfarFovCfg -1 0 0.5 8.92
cfarFovCfg -1 1 -1 1.00
sensorStart
)";

std::string with(const std::string& command, const std::string& replacement) {
  std::string text = kGood;
  const std::size_t at = text.find("\n" + command) + 1;
  return text.replace(at, text.find('\n', at) - at, replacement);
}

std::string fault(const std::string& text) {
  const auto config = parse_ti_config(text, "f.cfg");
  return config ? "" : config.error().to_string();
}

TEST(TiConfig, ReadsTheCommands) {
  const auto config = parse_ti_config(kGood, "f.cfg");
  ASSERT_TRUE(config) << config.error().to_string();
  EXPECT_EQ(config->rx_mask, 15U);
  EXPECT_EQ(config->tx_mask, 5U);
  EXPECT_EQ(config->profile.samples, 256);
  EXPECT_EQ(config->chirps.size(), 2U);
  EXPECT_EQ(config->frame.loops, 16);
  EXPECT_TRUE(config->cfar[0].on);
  EXPECT_FALSE(config->cfar[1].on);
  EXPECT_EQ(config->cfar[0].threshold, 9.0);
  EXPECT_TRUE(config->clutter_removal);
  EXPECT_EQ(config->min_range_m, 0.5);
  EXPECT_EQ(config->max_speed_mps, 1.0);
  EXPECT_DOUBLE_EQ(config->max_azimuth.radians(), Angle::degrees(70.0).radians());
  EXPECT_EQ(config->others, (std::vector<std::string>{"sensorStop", "adcCfg 2 1", "sensorStart"}));
}

// By hand: the slope is 1449 units of 3.6e9 · 900 / 2^26 Hz/µs, 69.9574 MHz/µs; 256 samples at
// 5.209 MHz are 49.1457 µs, in which it sweeps 3438.10 MHz from 77 + 0.489702 GHz on; the middle is
// 79.208752 GHz. 429 + 57.14 µs, two transmitters, 16 loops: 15.55648 ms.
TEST(TiConfig, Limits) {
  const auto config = parse_ti_config(kGood, "f.cfg");
  ASSERT_TRUE(config);
  const TiLimits limits = limits_of(*config);
  EXPECT_NEAR(limits.centre_hz, 79.208752e9, 1e4);
  EXPECT_NEAR(limits.bandwidth_hz, 3.43810e9, 1e4);
  EXPECT_EQ(limits.transmitters, 2);
  EXPECT_EQ(limits.range_bins, 256);
  EXPECT_EQ(limits.doppler_bins, 16);
  EXPECT_EQ(limits.azimuth_antennas, 8);
  EXPECT_NEAR(limits.range_step_m, 0.0436290, 1e-6);  // 3e8 · 5.209e6 / (2 · 69.9574e12 · 256)
  EXPECT_NEAR(limits.range_resolution_m, 0.0436290, 1e-6);
  EXPECT_NEAR(limits.speed_step_mps, 3e8 / (2.0 * 79.208752e9 * 0.01555648), 1e-6);
  EXPECT_NEAR(limits.max_speed_mps, 0.974, 0.001);
  EXPECT_EQ(limits.max_range_m, 8.92);  // the firmware's limit is below the last bin
  EXPECT_NEAR(limits.azimuth_resolution.radians(), 0.25, 1e-12);
}

TEST(TiConfig, FewerSamplesThanBins) {
  const auto config = parse_ti_config(
      with("profileCfg", "profileCfg 0 77 429 7 57.14 0 0 70 1 200 5209 0 0 30"), "f.cfg");
  ASSERT_TRUE(config);
  const TiLimits limits = limits_of(*config);
  EXPECT_EQ(limits.range_bins, 256);
  EXPECT_LT(limits.range_step_m,
            limits.range_resolution_m);  // interpolated, without better resolution
}

TEST(TiConfig, ErrorsNameTheLine) {
  using ::testing::HasSubstr;
  EXPECT_THAT(fault(with("channelCfg", "channelCfg 15")), HasSubstr("f.cfg:4: channelCfg"));
  EXPECT_THAT(fault(with("channelCfg", "channelCfg x 5 0")), HasSubstr("'x', is not a number"));
  EXPECT_THAT(fault(with("channelCfg", "channelCfg 16 5 0")), HasSubstr("mask 16"));
  EXPECT_THAT(fault(with("channelCfg", "channelCfg 0 5 0")), HasSubstr("needs a receiver"));
  EXPECT_THAT(fault(with("channelCfg", "channelCfg 15 1 0")), HasSubstr("leaves off"));
  EXPECT_THAT(fault(with("channelCfg", "")), HasSubstr("missing command channelCfg"));
  EXPECT_THAT(fault(with("dfeData", "dfeDataOutputMode 3")), HasSubstr("f.cfg:3"));
  EXPECT_THAT(fault(with("profileCfg", "profileCfg 0 10 429 7 57.14 0 0 70 1 256 5209 0 0 30")),
              HasSubstr("outside"));
  EXPECT_THAT(fault(with("profileCfg", "profileCfg 0 77 429 7 57.14 0 0 80 1 256 5209 0 0 30")),
              HasSubstr("leaves the band"));
  EXPECT_THAT(fault(with("profileCfg", "profileCfg 0 77 429 7 50 0 0 70 1 256 5209 0 0 30")),
              HasSubstr("after the ramp"));
  EXPECT_THAT(fault(with("profileCfg", "profileCfg 0 77 429 7 57.14 0 0 70 1 256 nan 0 0 30")),
              HasSubstr("not a number"));
  EXPECT_THAT(fault(with("profileCfg", "profileCfg 0 77 429 7 57.14 0 0 70 1 256 0 0 0 30")),
              HasSubstr("rate"));
  EXPECT_THAT(fault(with("profileCfg", "profileCfg 1 77 429 7 57.14 0 0 70 1 256 5209 0 0 30")),
              HasSubstr("profile is not defined"));
  EXPECT_THAT(fault(with("frameCfg", "frameCfg 0 2 16 0 100 1 0")), HasSubstr("chirp 2"));
  EXPECT_THAT(fault(with("frameCfg", "frameCfg 0 1 16 0 10 1 0")), HasSubstr("longer than"));
  EXPECT_THAT(fault(with("frameCfg", "frameCfg 0 1 0 0 100 1 0")), HasSubstr("invalid chirps"));
  EXPECT_THAT(fault(with("frameCfg", "advFrameCfg 1")), HasSubstr("advanced"));
  EXPECT_THAT(fault(with("cfarFovCfg", "cfarFovCfg -1 0 9 1")), HasSubstr("cfarFovCfg"));
  EXPECT_THAT(fault(""), HasSubstr("missing command"));
}

TEST(TiConfig, Captures) {
  for (const char* name : {"mer1", "mer2", "mer4", "mer6", "mer7", "mer9", "mer10", "dynmer1"}) {
    WAYFARE_NEEDS_RECORDING(path, "devices/ti_mmwave/awr1843_sdk3.6/" + std::string(name) + ".cfg");
    const auto config = parse_ti_config(testing::file_text(path), path);
    ASSERT_TRUE(config) << config.error().to_string();
    // The Doppler grid in the points of those captures, to a few roundings in single precision.
    EXPECT_NEAR(limits_of(*config).speed_step_mps, 0.12173257, 2e-8);
  }
}

}  // namespace
}  // namespace wayfare::decode
