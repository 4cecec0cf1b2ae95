// Frames, clock and configuration of a TI mmWave radar at their edges.
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>

#include "abuse/abuse.hpp"
#include "abuse/decode_streams.hpp"

namespace wayfare::decode {
namespace {

using tests::kNotFinite;
using tests::Stream;

TEST(TiAbuse, TheMagicWordIsNotSoughtBeyondTheEnd) {
  const Stream bytes(kTiMagic.begin(), kTiMagic.end());
  EXPECT_EQ(find_ti_magic(bytes, 0), 0U);
  for (const std::size_t from : {std::size_t{1}, std::size_t{8}, std::size_t{9}, SIZE_MAX - 9,
                                 SIZE_MAX - 7, SIZE_MAX - 3, SIZE_MAX})
    EXPECT_EQ(find_ti_magic(bytes, from), 8U) << from;
  EXPECT_EQ(find_ti_magic({}, 0), 0U);
}

TEST(TiAbuse, AnEmptyFrame) {
  const TiFrame frame;
  EXPECT_EQ(frame.size(), 0U);
  EXPECT_TRUE(frame.find(TiTlv::points).empty());
  EXPECT_FALSE(frame.statistics());
  EXPECT_FALSE(frame.temperature());
  EXPECT_TRUE(to_radar_scan(frame, LogTime{}).points.empty());
}

TEST(TiAbuse, PointsThatAreNotFiniteAreLeftOut) {
  for (const double bad : kNotFinite)
    for (std::size_t k = 0; k < 4; ++k) {
      std::vector<float> values = {1, 2, 3, 4, 5, 6, 7, 8};
      values[k] = static_cast<float>(bad);
      int seen = 0;
      tests::each_ti_frame(tests::ti_float_frame(values), [&](const TiFrame& frame) {
        ++seen;
        ASSERT_EQ(frame.size(), 2U);
        const RadarScan scan = to_radar_scan(frame, LogTime{});
        ASSERT_EQ(scan.points.size(), 1U);
        EXPECT_EQ(scan.points[0].x_m, 6.0F);
      });
      EXPECT_EQ(seen, 1);
    }
  // Before SDK 3 speeds are bins: a step that is not finite has none.
  int frames = 0;
  tests::each_ti_frame(tests::ti_fixed_frame(), [&](const TiFrame& frame) {
    ++frames;
    EXPECT_EQ(to_radar_scan(frame, LogTime{}, 0.1).points.size(), 1U);
    for (const double bad : kNotFinite)
      EXPECT_TRUE(to_radar_scan(frame, LogTime{}, bad).points.empty());
  });
  EXPECT_EQ(frames, 1);
}

TEST(TiAbuse, CountsAndLengthsAtTheLimitsOfTheirTypes) {
  const Stream good = tests::ti_float_frame({1, 2, 3, 4});
  for (std::size_t at = 8; at + 4 <= good.size(); at += 4)
    for (const std::uint32_t word :
         {0U, 1U, 7U, 8U, 0x7FFFFFFFU, 0x80000000U, 0xFFFFFFF8U, 0xFFFFFFFFU, 0x10000U, 0xFFFFU}) {
      Stream bytes = good;
      store_le(word, &bytes[at]);
      tests::append(bytes, good);
      tests::each_ti_frame(bytes, [](const TiFrame& frame) {
        std::size_t items = 0;
        frame.for_each([&](std::uint32_t, Bytes) { ++items; });
        EXPECT_EQ(items, frame.header().tlvs);
        static_cast<void>(to_radar_scan(frame, LogTime{}));
      });
    }
}

TEST(TiAbuse, TheClockOfMixedHeaders) {
  TiClock clock;
  Rng rng(2);
  Time<DeviceClock> last;
  for (int i = 0; i < 10'000; ++i) {
    TiHeader header;
    header.version = 0x03000000U;
    header.cycles = static_cast<std::uint32_t>(rng());
    const auto at = clock.at(header);
    ASSERT_GE(at, last) << "cycles only wrap forwards";
    last = at;
  }
}

std::string config_text(const std::string& profile, const std::string& frame = "0 0 16 0 100 1 0") {
  return "channelCfg 15 1 0\nprofileCfg " + profile + "\nchirpCfg 0 0 0 0 0 0 0 1\nframeCfg " +
         frame + "\n";
}

TEST(TiConfigAbuse, WhatIsAcceptedHasFiniteLimits) {
  Rng rng(3);
  const std::array<const char*, 22> values = {
      "0",   "-0",  "1",    "-1",      "77",   "60",    "1e-300", "1e300",  "1e9",   "0.01", "nan",
      "inf", "256", "8192", "1000000", "5209", "37500", "70",     "0.0001", "57.14", "7",    "300"};
  const auto word = [&] { return std::string(values[rng.below(values.size())]); };
  std::size_t accepted = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    std::vector<std::string> p = {"0",  "77", "429", "7",    "57.14", "0", "0",
                                  "70", "1",  "256", "5209", "0",     "0", "30"};
    std::vector<std::string> f = {"0", "0", "16", "0", "100", "1", "0"};
    for (auto k = 1 + rng.below(2); k > 0; --k) p[rng.below(p.size())] = word();
    if (trial % 3 == 0) f[rng.below(f.size())] = word();
    std::string profile, frame;
    for (const auto& w : p) profile += w + " ";
    for (const auto& w : f) frame += w + " ";
    const auto config = parse_ti_config(config_text(profile, frame), "f.cfg");
    if (!config) continue;
    ++accepted;
    const TiLimits l = limits_of(*config);
    for (const double value :
         {l.centre_hz, l.bandwidth_hz, l.range_step_m, l.range_resolution_m, l.max_range_m,
          l.speed_step_mps, l.max_speed_mps, l.azimuth_resolution.radians()})
      ASSERT_TRUE(std::isfinite(value) && value > 0.0) << profile << "/ " << frame;
  }
  EXPECT_GT(accepted, 1000U);
}

TEST(TiConfigAbuse, ASlopeBelowTheSynthesizersStepIsRefused) {
  const std::string flat = "0 77 429 7 57.14 0 0 0.01 1 256 5209 0 0 30";
  const auto config = parse_ti_config(config_text(flat), "f.cfg");
  ASSERT_FALSE(config);
  EXPECT_NE(config.error().to_string().find("slope out of range"), std::string::npos);
}

TEST(TiConfigAbuse, LongAndStrangeTexts) {
  const std::string good = config_text("0 77 429 7 57.14 0 0 70 1 256 5209 0 0 30");
  ASSERT_TRUE(parse_ti_config(good, "f.cfg"));
  EXPECT_FALSE(parse_ti_config(std::string(1'000'000, ' '), "f.cfg"));
  EXPECT_FALSE(parse_ti_config(std::string(1'000'000, '\n'), "f.cfg"));
  EXPECT_FALSE(parse_ti_config(std::string("\0\0\0", 3), "f.cfg"));
  std::string words = "profileCfg";
  for (int i = 0; i < 200'000; ++i) words += " 1";
  EXPECT_FALSE(parse_ti_config(words, "f.cfg"));
  std::string chirps = good;
  for (int i = 0; i < 20'000; ++i) chirps += "chirpCfg 0 511 0 0 0 0 0 1\n";
  EXPECT_TRUE(parse_ti_config(chirps, "f.cfg"));
  // Lines with either end, and one without.
  std::string other = good;
  for (std::size_t at = 0; (at = other.find('\n', at)) != other.npos; at += 2)
    other.insert(at, "\r");
  EXPECT_TRUE(parse_ti_config(other, "f.cfg"));
  EXPECT_TRUE(parse_ti_config(std::string_view(good).substr(0, good.size() - 1), "f.cfg"));
  Rng rng(4);
  for (int trial = 0; trial < 5000; ++trial) {
    std::string damaged = good;
    for (int k = 0; k < 3; ++k) damaged[rng.below(damaged.size())] = static_cast<char>(rng());
    const auto config = parse_ti_config(damaged, "f.cfg");
    if (!config) {
      EXPECT_EQ(config.error().source, "f.cfg");
    }
  }
}

}  // namespace
}  // namespace wayfare::decode
