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

TEST(TiConfig, ReadsEveryField) {
  const auto config = parse_ti_config(kGood, "f.cfg");
  ASSERT_TRUE(config);
  const TiProfile& p = config->profile;
  EXPECT_EQ(p.id, 0);
  EXPECT_EQ(p.start_ghz, 77.0);
  EXPECT_EQ(p.idle_us, 429.0);
  EXPECT_EQ(p.adc_start_us, 7.0);
  EXPECT_EQ(p.ramp_end_us, 57.14);
  EXPECT_EQ(p.slope_mhz_per_us, 70.0);
  EXPECT_EQ(p.sample_ksps, 5209.0);
  EXPECT_EQ(p.gain_db, 30.0);
  const auto chirps = parse_ti_config(with("chirpCfg 1", "chirpCfg 1 9 0 0 0 0 0 4"), "f.cfg");
  ASSERT_TRUE(chirps && chirps->chirps.size() == 2);
  EXPECT_EQ(chirps->chirps[0].tx_mask, 1U);
  EXPECT_EQ(chirps->chirps[1].first, 1);
  EXPECT_EQ(chirps->chirps[1].last, 9);
  EXPECT_EQ(chirps->chirps[1].profile, 0);
  EXPECT_EQ(chirps->chirps[1].tx_mask, 4U);
  EXPECT_EQ(config->frame.first_chirp, 0);
  EXPECT_EQ(config->frame.last_chirp, 1);
  EXPECT_EQ(config->frame.frames, 0);
  EXPECT_EQ(config->frame.period_ms, 100.0);
  EXPECT_EQ(config->max_range_m, 8.92);
  EXPECT_EQ(config->min_speed_mps, -1.0);
  EXPECT_NEAR(config->min_azimuth.degrees(), -80.0, 1e-12);
  EXPECT_NEAR(config->min_elevation.degrees(), -20.0, 1e-12);
  EXPECT_NEAR(config->max_elevation.degrees(), 30.0, 1e-12);
  EXPECT_FALSE(config->extended_velocity);
  const auto doppler = parse_ti_config(with("cfarCfg", "cfarCfg -1 1 2 8 4 3 0 7.5 0"), "f.cfg");
  ASSERT_TRUE(doppler);
  EXPECT_FALSE(doppler->cfar[0].on);
  EXPECT_TRUE(doppler->cfar[1].on);
  EXPECT_EQ(doppler->cfar[1].threshold, 7.5);
  const auto rest = parse_ti_config(with("clutterRemoval", "clutterRemoval -1 0"), "f.cfg");
  ASSERT_TRUE(rest);
  EXPECT_FALSE(rest->clutter_removal);
}

TEST(TiConfig, CommandsHaveAllArguments) {
  const std::pair<const char*, int> commands[] = {
      {"dfeDataOutputMode 1", 1},
      {"channelCfg 15 5", 2},
      {"profileCfg 0 77 429 7 57.14 0 0 70 1 256 5209 0 0 30", 14},
      {"chirpCfg 1 1 0 0 0 0 0 4", 8},
      {"frameCfg 0 1 16 0 100", 5},
      {"cfarCfg -1 0 2 8 4 3 0 9", 8},
      {"clutterRemoval -1 1", 2},
      {"extendedMaxVelocity -1 1", 2},
      {"aoaFovCfg -1 -80 70 -20 30", 5},
      {"cfarFovCfg -1 0 0.5 8.92", 4}};
  for (const auto& [command, n] : commands) {
    EXPECT_EQ(fault(kGood + command + "\n"), "");
    const std::string shorter(command, std::string(command).rfind(' '));
    EXPECT_THAT(fault(kGood + shorter + "\n"),
                ::testing::HasSubstr("expected at least " + std::to_string(n) +
                                     " arguments, found " + std::to_string(n - 1)))
        << command;
  }
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
  EXPECT_NEAR(limits.range_step_m, 0.0436287, 1e-7);  // 3e8 · 5.209e6 / (2 · 69.9574e12 · 256)
  EXPECT_NEAR(limits.range_resolution_m, 0.0436287, 1e-7);
  EXPECT_NEAR(limits.speed_step_mps, 3e8 / (2.0 * 79.208752e9 * 0.01555648), 1e-6);
  EXPECT_NEAR(limits.max_speed_mps, 0.974, 0.001);
  EXPECT_EQ(limits.max_range_m, 8.92);  // the firmware's limit is below the last bin
  EXPECT_NEAR(limits.azimuth_resolution.radians(), 0.25, 1e-12);
}

TiLimits limits_from(const std::string& text) {
  const auto config = parse_ti_config(text, "f.cfg");
  EXPECT_TRUE(config) << config.error().to_string();
  return config ? limits_of(*config) : TiLimits{};
}

// By hand: the slope is 1933 units of 2.7e9 · 900 / 2^26 Hz/µs, 69.993585 MHz/µs; the middle is
// 60 + 0.489955 GHz + half of 3.439884 GHz.
TEST(TiConfig, LimitsAt60GHz) {
  const TiLimits limits =
      limits_from(with("profileCfg", "profileCfg 0 60 429 7 57.14 0 0 70 1 256 5209 0 0 30"));
  EXPECT_NEAR(limits.bandwidth_hz, 3.439884e9, 1e4);
  EXPECT_NEAR(limits.centre_hz, 62.209897e9, 1e4);
}

// The first word of `text` that begins with `from` gives way to `to`.
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(TiConfig, LimitsOfOtherFrames) {
  // Without a limit of the firmware the last bin: 255 steps of 0.0436287 m. 64 bins of the sine.
  const TiLimits open = limits_from(with("cfarFovCfg -1 0", ""));
  EXPECT_NEAR(open.max_range_m, 255 * 0.0436287, 1e-4);
  EXPECT_NEAR(open.sin_azimuth_step, 2.0 / 64.0, 1e-15);
  EXPECT_NEAR(limits_from(with("clutterRemoval", "extendedMaxVelocity -1 1")).max_speed_mps,
              2.0 * open.max_speed_mps, 1e-12);
  // 20 chirps of each transmitter fill 32 bins.
  EXPECT_EQ(limits_from(with("frameCfg", "frameCfg 0 1 20 0 100 1 0")).doppler_bins, 32);
  // The transmitters of the chirps in the frame: TX1, TX3; all; TX2, which is above the row. The
  // speed's step goes with the time from chirp to chirp of a transmitter.
  const std::string all = with("channelCfg", "channelCfg 15 7 0") + "chirpCfg 2 2 0 0 0 0 0 2\n";
  struct Case {
    std::string chirps;
    int transmitters, antennas;
  };
  for (const Case& c : {Case{"0 1", 2, 8}, {"0 2", 3, 8}, {"1 2", 2, 4}, {"2 2", 1, 4}}) {
    const TiLimits limits = limits_from(replaced(all, "frameCfg 0 1", "frameCfg " + c.chirps));
    EXPECT_EQ(limits.transmitters, c.transmitters) << c.chirps;
    EXPECT_EQ(limits.azimuth_antennas, c.antennas) << c.chirps;
    EXPECT_NEAR(limits.azimuth_resolution.radians(), 2.0 / c.antennas, 1e-12) << c.chirps;
    EXPECT_EQ(limits.doppler_bins, 16) << c.chirps;
    EXPECT_NEAR(limits.speed_step_mps, open.speed_step_mps * 2.0 / c.transmitters, 1e-9);
  }
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

// The last value that is accepted, and the first that is not with what it is told. A unit of the
// slope is 0.0483 MHz/µs at 77 GHz and 0.0362 MHz/µs at 60 GHz.
TEST(TiConfig, LimitsOfTheChip) {
  struct Case {
    std::string command, text, fault;
  };
  const std::string outside = "outside", band = "leaves the band", samples = "number of samples",
                    rate = "sampling rate", time = "negative time", slope = "slope",
                    after = "after the ramp", chirps = "range of chirps", mask = "mask 8",
                    frame = "invalid chirps", whole = "is not an integer";
  const std::vector<Case> cases = {
      {"profileCfg 0", "76 429 7 57.14 0 0 70 1 256 5209 0 0 30", ""},
      {"profileCfg 0", "75.99 429 7 57.14 0 0 70 1 256 5209 0 0 30", outside},
      {"profileCfg 0", "81 429 7 57.14 0 0 70 1 256 5209 0 0 30", band},
      {"profileCfg 0", "81.01 429 7 57.14 0 0 70 1 256 5209 0 0 30", outside},
      {"profileCfg 0", "57 429 7 57.14 0 0 70 1 256 5209 0 0 30", ""},
      {"profileCfg 0", "56.99 429 7 57.14 0 0 70 1 256 5209 0 0 30", outside},
      {"profileCfg 0", "64 429 7 57.14 0 0 70 1 256 5209 0 0 30", band},
      {"profileCfg 0", "64.01 429 7 57.14 0 0 70 1 256 5209 0 0 30", outside},
      // 50 µs at 80 MHz/µs are 4 GHz.
      {"profileCfg 0", "77 429 7 50 0 0 80 1 200 5209 0 0 30", ""},
      {"profileCfg 0", "77 429 7 50.1 0 0 80 1 200 5209 0 0 30", band},
      {"profileCfg 0", "60 429 7 50 0 0 80 1 200 5209 0 0 30", ""},
      {"profileCfg 0", "60 429 7 50.1 0 0 80 1 200 5209 0 0 30", band},
      {"profileCfg 0", "77 429 7 57.14 0 0 70 1 2 5209 0 0 30", ""},
      {"profileCfg 0", "77 429 7 57.14 0 0 70 1 1 5209 0 0 30", samples},
      {"profileCfg 0", "77 429 7 240 0 0 5 1 8192 37500 0 0 30", ""},  // 7 + 218.5 µs
      {"profileCfg 0", "77 429 7 240 0 0 5 1 8193 37500 0 0 30", samples},
      {"profileCfg 0", "77 429 7 240 0 0 5 1 256 37501 0 0 30", rate},
      {"profileCfg 0", "77 0 0 57.14 0 0 70 1 256 5209 0 0 30", ""},
      {"profileCfg 0", "77 -1 7 57.14 0 0 70 1 256 5209 0 0 30", time},
      {"profileCfg 0", "77 429 -1 57.14 0 0 70 1 256 5209 0 0 30", time},
      {"profileCfg 0", "77 429 7 13 0 0 300 1 16 5000 0 0 30", ""},
      {"profileCfg 0", "77 429 7 13 0 0 300.1 1 16 5000 0 0 30", slope},
      {"profileCfg 0", "77 429 7 57.14 0 0 0.0483 1 256 5209 0 0 30", ""},
      {"profileCfg 0", "77 429 7 57.14 0 0 0.0482 1 256 5209 0 0 30", slope},
      {"profileCfg 0", "60 429 7 57.14 0 0 0.0363 1 256 5209 0 0 30", ""},
      {"profileCfg 0", "60 429 7 57.14 0 0 0.0362 1 256 5209 0 0 30", slope},
      {"profileCfg 0", "77 429 7 47 0 0 70 1 200 5000 0 0 30", ""},  // 7 + 40 µs
      {"profileCfg 0", "77 429 7 46.99 0 0 70 1 200 5000 0 0 30", after},
      {"chirpCfg 1", "511 0 0 0 0 0 4", ""},
      {"chirpCfg 1", "512 0 0 0 0 0 4", chirps},
      {"chirpCfg 1", "0 0 0 0 0 0 4", chirps},
      {"chirpCfg 1", "1 0 0 0 0 0 0", chirps},
      {"chirpCfg 1", "1 0 0 0 0 0 8", mask},
      {"chirpCfg", "-1 1 0 0 0 0 0 1", chirps},
      {"frameCfg", "0 1 1 0 100 1 0", ""},
      {"frameCfg", "0 1 255 0 300 1 0", ""},
      {"frameCfg", "0 1 256 0 300 1 0", frame},
      {"frameCfg", "1 1 16 1000000 100 1 0", ""},
      {"frameCfg", "1 0 16 0 100 1 0", frame},
      {"frameCfg", "-1 1 16 0 100 1 0", frame},
      {"frameCfg", "0 511 1 0 300 1 0", "chirp 2 is not defined"},
      {"frameCfg", "0 512 1 0 300 1 0", frame},
      {"frameCfg", "0 1 16 -1 100 1 0", frame},
      {"frameCfg", "0 1 16 0 0 1 0", frame},
      {"frameCfg", "0 1 16 1000001 100 1 0", whole},
      {"frameCfg", "0 1 16 0.5 100 1 0", "argument 4 is not an integer"},
      {"channelCfg", "15 7 0", ""},
      {"channelCfg", "15 8 0", mask},
      {"channelCfg", "15 0 0", "a transmitter"},
      {"channelCfg", "-1 5 0", "mask -1"},
      {"cfarCfg", "-1 2 2 8 4 3 0 9 0", "direction"},
      {"cfarFovCfg -1", "0 5 5", ""},
      {"cfarFovCfg -1", "2 0.5 8.92", "direction"},
  };
  for (const Case& c : cases) {
    const std::string found = fault(with(c.command, c.command + " " + c.text));
    EXPECT_THAT(found, ::testing::HasSubstr(c.fault)) << c.command << " " << c.text;
    EXPECT_EQ(found.empty(), c.fault.empty()) << c.command << " " << c.text << ": " << found;
  }
  // 443 + 57 µs, 2 · 16 chirps: 16 ms.
  const std::string full = with("profileCfg", "profileCfg 0 77 443 7 57 0 0 70 1 256 5209 0 0 30");
  EXPECT_EQ(fault(replaced(full, "frameCfg 0 1 16 0 100", "frameCfg 0 1 16 0 16")), "");
  EXPECT_THAT(fault(replaced(full, "frameCfg 0 1 16 0 100", "frameCfg 0 1 16 0 15.99")),
              ::testing::HasSubstr("longer than its period"));
  EXPECT_THAT(fault(with("frameCfg", "subFrameCfg 0")), ::testing::HasSubstr("advanced"));
  EXPECT_THAT(fault(with("chirpCfg 1", "chirpCfg 1 1 1 0 0 0 0 4") +
                    "profileCfg 1 77 429 7 57.14 0 0 70 1 256 5209 0 0 30\n"),
              ::testing::HasSubstr("different profiles"));
}

TEST(TiConfig, Captures) {
  for (const char* name : {"mer1", "mer2", "mer4", "mer6", "mer7", "mer9", "mer10", "dynmer1"}) {
    WAYFARE_NEEDS_RECORDING(path, "devices/ti_mmwave/awr1843_sdk3.6/" + std::string(name) + ".cfg");
    const auto config = parse_ti_config(testing::file_text(path), path);
    ASSERT_TRUE(config) << config.error().to_string();
    // The least speed of a point in mer1's table of its authors (column v), which the demo computed
    // in single precision: to a few roundings.
    EXPECT_NEAR(limits_of(*config).speed_step_mps, 0.12173257, 2e-8);
  }
}

}  // namespace
}  // namespace wayfare::decode
