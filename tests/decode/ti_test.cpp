#include <wayfare/decode/ti_decoder.hpp>

#include <cmath>
#include <tuple>
#include <utility>

#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/testing/decoder_laws.hpp>

#include "ti_streams.hpp"

namespace wayfare::decode {
namespace {

TEST(Ti, MagicWordIsFoundAtAnyOffset) {
  Rng rng(3);
  for (int trial = 0; trial < 2000; ++trial) {
    Stream bytes(rng.below(60));
    // Mostly bytes of the word itself, the worst case around it.
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
  // 16 bytes of payload: as long as a float point; the version decides.
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

// The first SDK up to 1.0.0.5 and xWR14xx have 36 bytes.
TEST(Ti, BytesOfTheDemosHeader) {
  for (const auto& [version, platform, bytes] : {std::tuple{0x01000005U, 0xA1642U, 36U},
                                                 {0x01000006U, 0xA1642U, 40U},
                                                 {0x03060000U, 0xA1443U, 36U},
                                                 {0x03060000U, 0xA1843U, 40U}})
    EXPECT_EQ((TiHeader{version, 0, platform}.bytes()), bytes) << version << ", " << platform;
}

TEST(Ti, StatisticsAndTemperatures) {
  for (const std::uint32_t report : {0U, 1U}) {
    Item temperatures = item_of<std::uint32_t>(9, {report, 123'456});
    for (int i = 0; i < 10; ++i)
      append(temperatures.payload, static_cast<std::int16_t>(20 - 5 * i));
    const Item statistics = item_of<std::uint32_t>(6, {1, 2, 3, 4, 5, 6});
    int frames = 0;
    each_frame(frame(1, 0, {statistics, temperatures}), [&](const TiFrame& f) {
      ++frames;
      const TiStatistics s = f.statistics().value_or(TiStatistics{});
      EXPECT_EQ(s.processing_us, 1U);
      EXPECT_EQ(s.transmit_us, 2U);
      EXPECT_EQ(s.frame_margin_us, 3U);
      EXPECT_EQ(s.chirp_margin_us, 4U);
      EXPECT_EQ(s.active_load_percent, 5U);
      EXPECT_EQ(s.idle_load_percent, 6U);
      const TiTemperature t = f.temperature().value_or(TiTemperature{});
      EXPECT_EQ(t.valid, report == 0);
      EXPECT_EQ(t.time_ms, 123'456U);
      for (int i = 0; i < 10; ++i) EXPECT_EQ(t.celsius[i], 20 - 5 * i) << i;
    });
    EXPECT_EQ(frames, 1);
  }
}

TEST(Ti, UnknownAndMalformedItemsAreSkipped) {
  const Stream bytes =
      frame(1, 1, {{1000, Stream(77)}, float_points(1), {6, Stream(128)}, {9, {}}});
  int frames = 0;
  each_frame(bytes, [&](const TiFrame& f) {
    ++frames;
    EXPECT_EQ(f.size(), 1U);
    EXPECT_FALSE(f.statistics());  // 128 bytes are not its known length
    EXPECT_FALSE(f.temperature());
    std::vector<std::uint32_t> types;
    f.for_each([&](std::uint32_t type, Bytes) { types.push_back(type); });
    EXPECT_EQ(types, (std::vector<std::uint32_t>{1000, 1, 6, 9}));
  });
  EXPECT_EQ(frames, 1);
}

TEST(Ti, InconsistentFramesAreRejected) {
  const Stream good = frame(1, 2, {float_points(2), side_info(2)});
  const auto with = [&](std::size_t at, std::uint32_t word) {
    Stream bytes = good;
    store_le(word, &bytes[at]);
    return numbers(joined({bytes, frame(2, 0, {})}));
  };
  const std::vector<std::uint32_t> second = {2}, both = {1, 2};
  EXPECT_EQ(with(20, 1), both);             // unchanged
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

TEST(Ti, AFrameWithTooLargeALengthEndsAtTheNextFrame) {
  Stream first = frame(1, 1, {float_points(1)});
  store_le(static_cast<std::uint32_t>(first.size() + 32), &first[12]);
  EXPECT_EQ(numbers(joined({first, frame(2, 0, {}), frame(3, 0, {})})),
            (std::vector<std::uint32_t>{1, 2, 3}));
}

TEST(Ti, LostBytesDoNotHideTheNextFrame) {
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

TEST(Ti, CyclesWrapAround) {
  TiClock clock;
  TiHeader header{0x03060000, 0, 0xA1843, 1, 4'294'967'000U, 0, 0, 0};
  const auto first = clock.at(header);
  header.cycles += 20'000'000U;  // 0.1 s at 200 MHz, past 2³²
  EXPECT_EQ(clock.at(header) - first, std::chrono::milliseconds(100));
}

// 200 MHz from SDK 3 on, 600 MHz before.
TEST(Ti, TheClockRunsAsFastAsItsCore) {
  for (const auto& [version, hz] :
       {std::pair{0x02010000U, 600e6}, {0x03000000U, 200e6}, {0x05050000U, 200e6}}) {
    TiClock clock;
    TiHeader header{version, 0, 0xA1843, 1, 6'000'000U, 0, 0, 0};
    const auto first = clock.at(header);
    EXPECT_EQ(first.nanoseconds(), std::llround(6e6 * 1e9 / hz));
    header.cycles += 60'000'000U;
    EXPECT_EQ(clock.at(header) - first, from_seconds(60e6 / hz));
  }
}

TEST(Ti, SatisfiesTheLaws) {
  std::vector<Stream> frames;
  for (int i = 0; i < 12; ++i)
    frames.push_back(frame(static_cast<std::uint32_t>(i + 1), static_cast<std::uint32_t>(i),
                           {float_points(i), side_info(i), {2, Stream(512, 3)}, {6, Stream(24)}}));
  testing::DecoderLaws<TiDecoder>{joined(frames), kAsText}.check();
}

}  // namespace
}  // namespace wayfare::decode
