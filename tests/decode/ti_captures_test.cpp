#include <charconv>
#include <cmath>
#include <sstream>

#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/testing/decoder_laws.hpp>

#include "ti_streams.hpp"

namespace wayfare::decode {
namespace {

struct Capture {
  const char* name;
  std::size_t frames;      ///< complete ones, counted by an independent walk from length to length
  std::size_t lead, rest;  ///< bytes before the first and after the last
};

constexpr const char* kFolder = "devices/ti_mmwave/awr1843_sdk3.6/";

TEST(TiCaptures, EveryPacketOfEveryFile) {
  constexpr Capture kCaptures[] = {
      {"dynmer1", 199, 1992, 2736}, {"dynmer2_3", 287, 2392, 2736}, {"mer1", 100, 0, 2280},
      {"mer2", 99, 2552, 1824},     {"mer4", 100, 0, 1368},         {"mer6", 100, 1048, 0},
      {"mer7", 100, 0, 3648},       {"mer9", 100, 0, 2736},         {"mer10", 100, 0, 2736}};
  for (const Capture& capture : kCaptures) {
    WAYFARE_NEEDS_RECORDING(path, kFolder + std::string(capture.name) + ".dat.gz");
    const Stream bytes = testing::file_bytes(path);
    std::uint32_t next = 0;
    TiClock clock;
    std::optional<Time<DeviceClock>> before;
    const auto statistics = each_frame(bytes, [&](const TiFrame& f) {
      const TiHeader& h = f.header();
      ASSERT_TRUE(next == 0 || h.frame_number == next) << capture.name;
      next = h.frame_number + 1;
      ASSERT_EQ(h.version, 0x03060000U);
      ASSERT_EQ(h.bytes(), 40U);
      ASSERT_EQ(f.has_side_info(), f.size() > 0);
      ASSERT_EQ(f.find(TiTlv::range_profile).size(), 512U);
      ASSERT_TRUE(f.statistics());
      const TiTemperature temperature = f.temperature().value_or(TiTemperature{});
      ASSERT_TRUE(temperature.valid);
      for (const std::int16_t t : temperature.celsius) ASSERT_TRUE(t > 10 && t < 90);
      // 100 ms frames; the counter is read when a frame is complete, which takes longer with more
      // points.
      const auto now = clock.at(h);
      if (before) {
        ASSERT_NEAR(to_seconds(now - *before), 0.1, 0.002);
      }
      before = now;
    });
    EXPECT_EQ(statistics.frames, capture.frames) << capture.name;
    EXPECT_EQ(statistics.skipped_bytes, capture.lead + capture.rest) << capture.name;
    EXPECT_LE(statistics.malformed, 1U) << capture.name;  // the last one, cut off
  }
}

TEST(TiCaptures, MatchTheAuthorsTablesBitForBit) {
  for (const char* name : {"mer1", "mer2"}) {
    WAYFARE_NEEDS_RECORDING(path, kFolder + std::string(name) + ".dat.gz");
    WAYFARE_NEEDS_RECORDING(table_path, kFolder + std::string("parsed_csv/") + name + ".csv.gz");
    std::istringstream table(testing::file_text(table_path));
    std::string line;
    std::getline(table, line);
    ASSERT_EQ(line, "frame,DetObj#,x,y,z,v,snr,noise");
    int index = 0;
    std::size_t rows = 0, different = 0;
    each_frame(testing::file_bytes(path), [&](const TiFrame& f) {
      for (std::size_t i = 0; i < f.size(); ++i) {
        ASSERT_TRUE(std::getline(table, line));
        std::istringstream fields(line);
        std::string field;
        std::vector<double> row;
        while (std::getline(fields, field, ',')) row.push_back(std::stod(field));
        const TiPoint p = f[i];
        const std::vector<double> ours = {double(index),     double(i),
                                          double(p.x_m),     double(p.y_m),
                                          double(p.z_m),     double(p.doppler_mps),
                                          double(p.snr_ddb), double(p.noise_ddb)};
        different += row == ours ? 0 : 1;
        ++rows;
      }
      ++index;
    });
    EXPECT_FALSE(std::getline(table, line)) << "rows that were not decoded";
    EXPECT_EQ(different, 0U) << name << " of " << rows;
    EXPECT_GT(rows, 10000U);
  }
}

// The points are on the grid of limits_of.
TEST(TiCaptures, PointsAreOnTheGrid) {
  WAYFARE_NEEDS_RECORDING(path, kFolder + std::string("dynmer1.dat.gz"));
  WAYFARE_NEEDS_RECORDING(config_path, kFolder + std::string("dynmer1.cfg"));
  const auto config = parse_ti_config(testing::file_text(config_path), config_path);
  ASSERT_TRUE(config);
  const TiLimits limits = limits_of(*config);
  const auto off_grid = [](double value, double step) {
    return std::abs(value / step - std::round(value / step));
  };
  double range = 0.0, speed = 0.0, azimuth = 0.0;
  std::size_t points = 0;
  each_frame(testing::file_bytes(path), [&](const TiFrame& f) {
    points += f.size();
    for (std::size_t i = 0; i < f.size(); ++i) {
      const TiPoint p = f[i];
      const double r = std::hypot(double(p.x_m), double(p.y_m));
      range = std::max(range, off_grid(r, limits.range_step_m));
      speed = std::max(speed, off_grid(double(p.doppler_mps), limits.speed_step_mps));
      azimuth = std::max(azimuth, off_grid(double(p.x_m) / r, limits.sin_azimuth_step));
      ASSERT_LE(r, limits.max_range_m + limits.range_step_m);
      ASSERT_LE(std::abs(double(p.doppler_mps)), limits.max_speed_mps + 1e-5);
    }
  });
  EXPECT_GT(points, 199U);  // there are as many frames
  EXPECT_LT(range, 1e-3);
  EXPECT_LT(speed, 1e-5);
  EXPECT_LT(azimuth, 1e-4);
}

TEST(TiCaptures, Sdk12) {
  WAYFARE_NEEDS_RECORDING(path, "devices/ti_mmwave/xwr1642_sdk1.2/oob_output_data.bin.gz");
  std::size_t points = 0;
  const auto statistics = each_frame(testing::file_bytes(path), [&](const TiFrame& f) {
    ASSERT_EQ(f.header().platform, 0xA1642U);
    points += f.size();
    for (std::size_t i = 0; i < f.size(); ++i) {
      const TiPoint p = f[i];
      const double range = std::hypot(p.x_m, p.y_m, p.z_m);
      ASSERT_LT(range, 64.0);
      // Range is proportional to its bin, to the rounding of Q9.
      if (p.range_bin > 20) {
        ASSERT_NEAR(range / p.range_bin, 0.044, 0.006);
      }
    }
  });
  EXPECT_EQ(statistics.frames, 347U);
  EXPECT_GT(points, 347U);
}

TEST(TiCaptures, SatisfyTheLawsUnderDamage) {
  WAYFARE_NEEDS_RECORDING(path, kFolder + std::string("mer1.dat.gz"));
  Stream bytes = testing::file_bytes(path);
  std::vector<std::uint64_t> starts;
  each_frame(bytes, [&](const TiFrame& f) { starts.push_back(f.position()); });
  bytes.resize(static_cast<std::size_t>(starts.at(4)));
  const testing::DecoderLaws<TiDecoder> laws{bytes, kAsText};
  laws.check();
  const testing::DamageReport report = laws.damage(10000);
  report.record("ti");
  EXPECT_EQ(report.lost, 0U);
  EXPECT_EQ(report.hidden, 0U);
  EXPECT_GT(report.undamaged, 15000U);
  // Without a checksum a frame with changed contents is delivered; but nothing is delivered that
  // was not sent as a frame.
  EXPECT_LE(report.false_frames, report.damaged);
}

}  // namespace
}  // namespace wayfare::decode
