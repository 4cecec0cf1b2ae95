#include <wayfare/decode/ti_decoder.hpp>

#include <charconv>
#include <cmath>
#include <sstream>

#include <wayfare/decode/ti_config.hpp>
#include <wayfare/decode/ti_radar_scan.hpp>
#include <wayfare/testing/decoder_laws.hpp>
#include "decode/captures.hpp"

namespace wayfare::decode {
namespace {

using Stream = std::vector<std::uint8_t>;

template <class T>
void append(Stream& out, T value) {
  out.resize(out.size() + sizeof(T));
  store_le(value, &out[out.size() - sizeof(T)]);
}

struct Item {
  std::uint32_t type = 0;
  Stream payload;
};

/// A frame built by the layout, its header of 36 or 40 bytes as version and platform want.
Stream frame(std::uint32_t number, std::uint32_t points, const std::vector<Item>& items,
             std::uint32_t version = 0x03060000, std::uint32_t platform = 0xA1843) {
  const TiHeader header{version, 0, platform, number, 0, points, 0, 0};
  Stream out(kTiMagic.begin(), kTiMagic.end());
  for (const std::uint32_t word : {version, 0U, platform, number, number * 20'000'000U, points,
                                   static_cast<std::uint32_t>(items.size())})
    append(out, word);
  if (header.bytes() == 40) append(out, 0U);
  for (const Item& item : items) {
    append(out, item.type);
    append(out, static_cast<std::uint32_t>(item.payload.size()));
    out.insert(out.end(), item.payload.begin(), item.payload.end());
  }
  out.resize((out.size() + 31) / 32 * 32, 0x0F);
  store_le(static_cast<std::uint32_t>(out.size()), &out[12]);
  return out;
}

Item float_points(int n) {
  Item item{1, {}};
  for (int i = 0; i < 4 * n; ++i) append(item.payload, 0.5F * static_cast<float>(i));
  return item;
}

Item side_info(int n) {
  Item item{7, {}};
  for (int i = 0; i < 2 * n; ++i) append(item.payload, static_cast<std::int16_t>(100 + i));
  return item;
}

Stream joined(const std::vector<Stream>& parts) {
  Stream all;
  for (const Stream& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

std::string text_of(const TiFrame& f) {
  return std::to_string(f.header().frame_number) + ":" + testing::fingerprint(f.bytes());
}

template <class F>
DecoderStatistics each_frame(const Stream& bytes, F&& f) {
  const auto decoder = std::make_unique<TiDecoder>();
  decoder->feed(bytes, f);
  decoder->finish(f);
  return decoder->statistics();
}

std::vector<std::uint32_t> numbers(const Stream& bytes) {
  std::vector<std::uint32_t> result;
  each_frame(bytes, [&](const TiFrame& f) { result.push_back(f.header().frame_number); });
  return result;
}

TEST(Ti, MagicWordIsFoundWhereverItStands) {
  Rng rng(3);
  for (int trial = 0; trial < 2000; ++trial) {
    Stream bytes(rng.below(60));
    // Mostly bytes of the word itself, the worst that can surround it.
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng.below(10));
    if (bytes.size() >= 8 && trial % 2 == 0) {
      const auto at = static_cast<long>(rng.below(bytes.size() - 7));
      std::copy(kTiMagic.begin(), kTiMagic.end(), bytes.begin() + at);
    }
    const auto expected =
        std::search(bytes.begin(), bytes.end(), kTiMagic.begin(), kTiMagic.end()) - bytes.begin();
    ASSERT_EQ(find_ti_magic(bytes, 0), static_cast<std::size_t>(expected));
  }
}

TEST(Ti, PointsCarryTheirSideInformation) {
  int frames = 0;
  each_frame(frame(7, 2, {float_points(2), side_info(2)}), [&](const TiFrame& f) {
    ++frames;
    ASSERT_EQ(f.size(), 2U);
    EXPECT_EQ(f[1].x_m, 2.0F);
    EXPECT_EQ(f[1].doppler_mps, 3.5F);
    EXPECT_EQ(f[1].snr_ddb, 102);
    EXPECT_EQ(f[1].noise_ddb, 103);
    const RadarScan scan = to_radar_scan(f, LogTime::from_nanoseconds(5));
    EXPECT_EQ(scan.points[1], (RadarPoint{2.5F, -2.0F, 3.0F, 3.5F, 10.2F}));
  });
  EXPECT_EQ(frames, 1);
}

TEST(Ti, FixedPointBeforeSdk3) {
  Item item{1, {}};
  append(item.payload, std::uint16_t{1});
  append(item.payload, std::uint16_t{9});
  for (const int v : {12, -3, 99, -512, 1024, 256})
    append(item.payload, static_cast<std::int16_t>(v));
  // 16 bytes of payload: a float point would be as long. The version tells.
  ASSERT_EQ(item.payload.size(), 16U);
  int frames = 0;
  each_frame(frame(1, 1, {item}, 0x01020005, 0xA1642), [&](const TiFrame& f) {
    ++frames;
    const TiPoint p = f[0];
    EXPECT_EQ(p.x_m, -1.0F);
    EXPECT_EQ(p.y_m, 2.0F);
    EXPECT_EQ(p.z_m, 0.5F);
    EXPECT_EQ(p.range_bin, 12);
    EXPECT_EQ(p.doppler_bin, -3);
    EXPECT_EQ(p.peak, 99);
    EXPECT_TRUE(std::isnan(p.doppler_mps));
    const RadarScan scan = to_radar_scan(f, LogTime{}, 0.25);
    EXPECT_EQ(scan.points[0].doppler_m_s, -0.75F);
    EXPECT_FLOAT_EQ(scan.points[0].snr_db, 20.0F);  // 10 log10(99 + 1)
  });
  EXPECT_EQ(frames, 1);
}

TEST(Ti, ShortHeaders) {
  for (const auto& [version, platform] :
       {std::pair{0x03060000U, 0xA1443U}, std::pair{0x01000005U, 0xA1642U}}) {
    const Stream bytes = frame(3, 0, {{6, Stream(24)}}, version, platform);
    int frames = 0;
    each_frame(bytes, [&](const TiFrame& f) {
      ++frames;
      EXPECT_EQ(f.header().bytes(), 36U);
      EXPECT_TRUE(f.statistics());
    });
    EXPECT_EQ(frames, 1);
  }
}

TEST(Ti, UnknownItemsAndOddOnesAreSkipped) {
  const Stream bytes =
      frame(1, 1, {{1000, Stream(77)}, float_points(1), {6, Stream(128)}, {9, {}}});
  int frames = 0;
  each_frame(bytes, [&](const TiFrame& f) {
    ++frames;
    EXPECT_EQ(f.size(), 1U);
    EXPECT_FALSE(f.statistics());  // 128 bytes are not what it is known to be
    EXPECT_FALSE(f.temperature());
    std::vector<std::uint32_t> types;
    f.for_each([&](std::uint32_t type, Bytes) { types.push_back(type); });
    EXPECT_EQ(types, (std::vector<std::uint32_t>{1000, 1, 6, 9}));
  });
  EXPECT_EQ(frames, 1);
}

TEST(Ti, ContradictionsAreRefused) {
  const Stream good = frame(1, 2, {float_points(2), side_info(2)});
  const auto with = [&](std::size_t at, std::uint32_t word) {
    Stream bytes = good;
    store_le(word, &bytes[at]);
    return numbers(joined({bytes, frame(2, 0, {})}));
  };
  const std::vector<std::uint32_t> second = {2}, both = {1, 2};
  EXPECT_EQ(with(20, 1), both);             // as it was
  EXPECT_EQ(with(12, 0xFFFFFFFF), second);  // length
  EXPECT_EQ(with(12, 65536), both);         // the next magic word ends it
  EXPECT_EQ(with(12, 65568), second);
  EXPECT_EQ(with(12, 0), second);
  EXPECT_EQ(with(12, 39), second);
  EXPECT_EQ(with(28, 3), second);  // points
  EXPECT_EQ(with(28, 0xFFFFFFFF), second);
  EXPECT_EQ(with(32, 3), second);  // items
  EXPECT_EQ(with(32, 0xFFFFFFFF), second);
  EXPECT_EQ(with(44, 0xFFFFFFF8), second);  // length of an item
  EXPECT_EQ(with(44, 33), second);
  EXPECT_EQ(with(84, 4), second);  // side information of one point, not two
}

TEST(Ti, AHeaderThatCountsTooManyBytesEndsAtTheNextFrame) {
  Stream first = frame(1, 1, {float_points(1)});
  store_le(static_cast<std::uint32_t>(first.size() + 32), &first[12]);
  EXPECT_EQ(numbers(joined({first, frame(2, 0, {}), frame(3, 0, {})})),
            (std::vector<std::uint32_t>{1, 2, 3}));
}

TEST(Ti, LostBytesDoNotCostTheNextFrame) {
  const Stream first = frame(1, 1, {float_points(1), {6, Stream(24, 0xAA)}});
  for (std::size_t lost = 1; lost < first.size(); ++lost) {
    for (const std::size_t at : {std::size_t{0}, first.size() - lost, (first.size() - lost) / 2}) {
      Stream cut = first;
      cut.erase(cut.begin() + static_cast<long>(at), cut.begin() + static_cast<long>(at + lost));
      const auto seen = numbers(joined({cut, frame(2, 0, {}), frame(3, 0, {})}));
      ASSERT_GE(seen.size(), 2U) << lost << " bytes at " << at;
      ASSERT_EQ(seen[seen.size() - 2], 2U);
      ASSERT_EQ(seen.back(), 3U);
    }
  }
}

TEST(Ti, CyclesComeRound) {
  TiClock clock;
  TiHeader header{0x03060000, 0, 0xA1843, 1, 4'294'967'000U, 0, 0, 0};
  const auto first = clock.at(header);
  header.cycles += 20'000'000U;  // 0.1 s at 200 MHz, past 2³²
  EXPECT_EQ(clock.at(header) - first, std::chrono::milliseconds(100));
}

TEST(Ti, KeepsTheLaws) {
  std::vector<Stream> frames;
  for (int i = 0; i < 12; ++i)
    frames.push_back(frame(static_cast<std::uint32_t>(i + 1), static_cast<std::uint32_t>(i),
                           {float_points(i), side_info(i), {2, Stream(512, 3)}, {6, Stream(24)}}));
  testing::DecoderLaws<TiDecoder>{joined(frames), text_of}.check();
}

// ---- captures ----

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
      // 100 ms frames; the counter is read when a frame is done, which takes longer with more
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

TEST(TiCaptures, AuthorsTablesBitForBit) {
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

// What limits_of says of the configuration is the grid the points are on.
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
  each_frame(testing::file_bytes(path), [&](const TiFrame& f) {
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
      // Range and its bin tell the same story: a constant metres a bin, to Q9's rounding.
      if (p.range_bin > 20) {
        ASSERT_NEAR(range / p.range_bin, 0.044, 0.006);
      }
    }
  });
  EXPECT_EQ(statistics.frames, 347U);
  EXPECT_GT(points, 347U);
}

TEST(TiCaptures, KeepTheLawsUnderDamage) {
  WAYFARE_NEEDS_RECORDING(path, kFolder + std::string("mer1.dat.gz"));
  Stream bytes = testing::file_bytes(path);
  std::vector<std::uint64_t> starts;
  each_frame(bytes, [&](const TiFrame& f) { starts.push_back(f.position()); });
  bytes.resize(starts.at(4));
  const testing::DecoderLaws<TiDecoder> laws{bytes, text_of};
  laws.check();
  const testing::DamageReport report = laws.damage(10000);
  report.record("ti");
  EXPECT_EQ(report.lost, 0U);
  EXPECT_EQ(report.hidden, 0U);
  EXPECT_GT(report.undamaged, 15000U);
  // Without a checksum a frame with changed contents is delivered as it came; but nothing is
  // delivered that was not sent as a frame.
  EXPECT_LE(report.false_frames, report.damaged);
}

}  // namespace
}  // namespace wayfare::decode
