// Frames of TI's people counting, area scanner and xWRL demos. There is no capture of them: they
// are encoded here by the layouts of TI's user's guides and headers.
#include <wayfare/decode/ti_tracking.hpp>

#include <cmath>

#include <gmock/gmock.h>

#include <wayfare/decode/ti_config.hpp>
#include <wayfare/decode/ti_header.hpp>
#include <wayfare/decode/ti_items.hpp>
#include <wayfare/decode/ti_refusal.hpp>
#include <wayfare/testing/decoder_laws.hpp>

#include "ti_streams.hpp"

namespace wayfare::decode {
namespace {

using ::testing::HasSubstr;

/// The only frame of a stream of one, passed to `f`.
template <class F>
void one_frame(const Stream& bytes, F&& f) {
  int frames = 0;
  const DecoderStatistics s = each_frame(bytes, [&](const TiFrame& frame) {
    ++frames;
    f(frame);
  });
  EXPECT_EQ(frames, 1);
  EXPECT_EQ(s.malformed, 0U);
  EXPECT_EQ(s.skipped_bytes, 0U);
}

std::vector<float> numbered(std::size_t n, float first = 1.0F) {
  std::vector<float> values;
  for (std::size_t i = 0; i < n; ++i) values.push_back(first + static_cast<float>(i));
  return values;
}

/// Entries of an identifier and floats.
Item entries(std::uint32_t type, const std::vector<std::vector<float>>& rows) {
  Item item{type, {}};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    append(item.payload, static_cast<std::uint32_t>(40 + i));
    for (const float v : rows[i]) append(item.payload, v);
  }
  return item;
}

// 2 m away, 0.4 rad to the right, 0.1 rad up.
void expect_point(const TiPoint& p, float snr_ratio) {
  EXPECT_NEAR(p.x_m, 2.0 * std::cos(0.1) * std::sin(0.4), 1e-5);
  EXPECT_NEAR(p.y_m, 2.0 * std::cos(0.1) * std::cos(0.4), 1e-5);
  EXPECT_NEAR(p.z_m, 2.0 * std::sin(0.1), 1e-5);
  EXPECT_FLOAT_EQ(p.doppler_mps, -1.5F);
  EXPECT_TRUE(snr_ratio == 0.0F || p.snr_ddb == std::lround(100.0 * std::log10(snr_ratio)));
}
const CompressedPoint kPoint{10, 20, -15, 8000, 500};  // 500 units of 0.04: 20, or 13.0 dB

TEST(TiTracking, PeopleCountingIn3dWithTheDemosHeader) {
  const Stream bytes =
      frame(3, 2,
            {compressed_points(1020, {kPoint, kPoint}), entries(1010, {numbered(27)}),
             item_of<std::uint8_t>(1011, {0, 255}), entries(1012, {{1.8F, 0.1F}, {1.2F, 0.3F}}),
             item_of<std::uint32_t>(1021, {1})});
  one_frame(bytes, [](const TiFrame& f) {
    EXPECT_EQ(f.header().layout, TiLayout::demo);
    EXPECT_EQ(f.encoding(), TiPoints::compressed);
    ASSERT_EQ(f.size(), 2U);
    expect_point(f[1], 20.0F);
    EXPECT_EQ(f[1].peak, 500);
    EXPECT_TRUE(f.has_strength());
    EXPECT_FALSE(f.has_noise());
    const TiTargets targets = ti_targets(f);
    ASSERT_EQ(targets.size(), 1U);
    EXPECT_EQ(targets[0].id, 40U);
    EXPECT_EQ(targets[0].position_m, (std::array<float, 3>{1, 2, 3}));
    EXPECT_EQ(targets[0].velocity_mps, (std::array<float, 3>{4, 5, 6}));
    EXPECT_EQ(targets[0].acceleration_mps2, (std::array<float, 3>{7, 8, 9}));
    EXPECT_EQ(targets[0].gain, 26.0F);
    EXPECT_EQ(targets[0].confidence, 27.0F);
    ASSERT_EQ(ti_target_index(f).size(), 2U);
    EXPECT_EQ(ti_target_index(f)[1], 255);
    ASSERT_EQ(ti_height_count(f), 2U);
    EXPECT_EQ(ti_height(f, 0).id, 40U);
    EXPECT_EQ(ti_height(f, 0).top_m, 1.8F);
    EXPECT_EQ(ti_height(f, 0).bottom_m, 0.1F);
    EXPECT_EQ(ti_height(f, 1).id, 41U);
    EXPECT_EQ(ti_height(f, 1).bottom_m, 0.3F);
    EXPECT_EQ(ti_presence(f), true);
    EXPECT_FALSE(ti_vital_signs(f));
    const RadarScan scan = to_radar_scan(f, LogTime{});
    ASSERT_EQ(scan.points.size(), 2U);
    EXPECT_NEAR(scan.points[0].y_m, -f[0].x_m, 1e-6);
    EXPECT_FLOAT_EQ(scan.points[0].snr_db, 13.0F);
  });
}

TEST(TiTracking, AFrameWithoutPointsOrWithoutTheirNumber) {
  one_frame(frame(3, 0, {entries(1010, {numbered(27), numbered(27)})}),
            [](const TiFrame& f) { EXPECT_EQ(ti_targets(f).size(), 2U); });
  // Some versions count the points before they are filtered.
  one_frame(frame(3, 9, {compressed_points(1020, {kPoint})}),
            [](const TiFrame& f) { EXPECT_EQ(f.size(), 1U); });
}

TEST(TiTracking, PeopleCountingIn3dWithAChecksum) {
  const Stream bytes =
      tracker_3d_frame(9, {compressed_points(6, {kPoint}), entries(7, {numbered(27)}),
                           item_of<std::uint8_t>(8, {40}), item_of<std::uint32_t>(11, {0})});
  one_frame(bytes, [](const TiFrame& f) {
    EXPECT_EQ(f.header().layout, TiLayout::tracker_3d);
    EXPECT_EQ(f.header().bytes(), 48U);
    EXPECT_EQ(f.header().frame_number, 9U);
    EXPECT_EQ(f.header().points, 1U);
    EXPECT_FALSE(f.header().has_clock());
    ASSERT_EQ(f.size(), 1U);
    expect_point(f[0], 20.0F);
    EXPECT_EQ(ti_targets(f)[0].confidence, 27.0F);
    EXPECT_EQ(ti_target_index(f)[0], 40);
    EXPECT_EQ(ti_presence(f), false);
  });
  // Times so short that they might be the demo's counts: the items decide.
  one_frame(tracker_3d_frame(9, {compressed_points(6, {kPoint, kPoint})}, 1),
            [](const TiFrame& f) { EXPECT_EQ(f.size(), 2U); });
}

TEST(TiTracking, PeopleCountingInAPlane) {
  const std::vector<float> point = {2.0F, 0.4F, -1.5F, 20.0F};
  for (const std::size_t floats : {16U, 17U}) {  // with and without the confidence
    const Stream bytes =
        tracker_2d_frame(5, {item_of<float>(6, point), entries(7, {numbered(floats)})});
    one_frame(bytes, [&](const TiFrame& f) {
      EXPECT_EQ(f.header().layout, TiLayout::tracker_2d);
      EXPECT_EQ(f.header().cycles, 300'000'000U);
      EXPECT_EQ(ti_clock_hz(f.header()), 600e6);
      ASSERT_EQ(f.size(), 1U);
      EXPECT_NEAR(f[0].x_m, 2.0 * std::sin(0.4), 1e-6);
      EXPECT_NEAR(f[0].y_m, 2.0 * std::cos(0.4), 1e-6);
      EXPECT_EQ(f[0].z_m, 0.0F);
      EXPECT_EQ(f[0].doppler_mps, -1.5F);
      EXPECT_EQ(f[0].snr_ddb, 130);
      const TiTarget t = ti_targets(f)[0];
      EXPECT_EQ(t.position_m, (std::array<float, 3>{1, 2, 0}));
      EXPECT_EQ(t.velocity_mps, (std::array<float, 3>{3, 4, 0}));
      EXPECT_EQ(t.acceleration_mps2, (std::array<float, 3>{5, 6, 0}));
      EXPECT_EQ(t.gain, 16.0F);
      EXPECT_EQ(std::isnan(t.confidence), floats == 16);
      if (floats == 17) {
        EXPECT_EQ(t.confidence, 17.0F);
      }
    });
  }
}

TEST(TiTracking, AreaScanner) {
  const std::vector<float> point = {2.0F, 0.4F, 0.1F, -1.5F};
  const Stream bytes = area_frame(4, 1, 1,
                                  {item_of<float>(1, point), item_of<std::int16_t>(7, {150, 90}),
                                   item_of<float>(8, point), item_of<std::int16_t>(9, {1, 2}),
                                   entries(10, {numbered(9)}), item_of<std::uint8_t>(11, {40})});
  one_frame(bytes, [](const TiFrame& f) {
    EXPECT_EQ(f.header().layout, TiLayout::area_scanner);
    EXPECT_EQ(f.header().bytes(), 44U);
    EXPECT_EQ(f.header().static_points, 1U);
    EXPECT_EQ(f.header().subframe, 2U);
    ASSERT_EQ(f.size(), 1U);
    expect_point(f[0], 0.0F);
    EXPECT_EQ(f[0].snr_ddb, 150);
    EXPECT_EQ(f[0].noise_ddb, 90);
    const TiTarget t = ti_targets(f)[0];
    EXPECT_EQ(t.position_m, (std::array<float, 3>{1, 2, 7}));
    EXPECT_EQ(t.velocity_mps, (std::array<float, 3>{3, 4, 8}));
    EXPECT_EQ(t.acceleration_mps2, (std::array<float, 3>{5, 6, 9}));
    EXPECT_EQ(ti_target_index(f).size(), 1U);
  });
}

TEST(TiTracking, PointsOfLowPowerSensors) {
  Item item = item_of<float>(301, {0.01F, 0.5F, 0.25F, 2.0F});
  append(item.payload, std::uint16_t{1});
  append(item.payload, std::uint16_t{0});
  for (const int v : {-100, 250, 30, -3}) append(item.payload, static_cast<std::int16_t>(v));
  append(item.payload, std::uint8_t{60});
  append(item.payload, std::uint8_t{20});
  one_frame(frame(1, 1, {item, item_of<std::uint32_t>(302, {1, 2, 3})}, 0x05050000, 0xA6432),
            [](const TiFrame& f) {
              EXPECT_EQ(f.encoding(), TiPoints::packed);
              ASSERT_EQ(f.size(), 1U);
              EXPECT_FLOAT_EQ(f[0].x_m, -1.0F);
              EXPECT_FLOAT_EQ(f[0].y_m, 2.5F);
              EXPECT_FLOAT_EQ(f[0].z_m, 0.3F);
              EXPECT_FLOAT_EQ(f[0].doppler_mps, -1.5F);
              EXPECT_EQ(f[0].snr_ddb, 150);
              EXPECT_EQ(f[0].noise_ddb, 400);
              EXPECT_TRUE(f.has_noise());
              EXPECT_EQ(f.find(TiTlv::range_profile_major).size(), 12U);
              ASSERT_EQ(ti_linear_profile(f).size(), 3U);
              EXPECT_EQ(ti_linear_profile(f)[2], 3U);
              std::vector<float> noise{1.0F, 2.0F};
              const RadarScan scan = to_radar_scan(f, LogTime{}, 0.0, &noise);
              ASSERT_EQ(scan.points.size(), 1U);
              EXPECT_FLOAT_EQ(scan.points[0].snr_db, 15.0F);
              EXPECT_EQ(noise, std::vector<float>{40.0F});  // 400 tenths of dB
            });
  // Without a noise of the points there is none, whatever was there before.
  one_frame(frame(1, 1, {float_points(1)}), [](const TiFrame& f) {
    std::vector<float> noise{1.0F};
    EXPECT_EQ(to_radar_scan(f, LogTime{}, 0.0, &noise).points.size(), 1U);
    EXPECT_TRUE(noise.empty());
  });
}

// Items 308 and 309 are as 1010 and 1011, which come first; 303 is as 302.
TEST(TiTracking, TargetsAndProfilesOfLowPowerSensors) {
  const std::vector<Item> packed = {entries(308, {numbered(27, 2.0F)}),
                                    item_of<std::uint8_t>(309, {7, 254}),
                                    item_of<std::uint32_t>(303, {4, 5})};
  one_frame(frame(1, 0, packed, 0x05050000, 0xA6432), [](const TiFrame& f) {
    ASSERT_EQ(ti_targets(f).size(), 1U);
    EXPECT_EQ(ti_targets(f)[0].position_m, (std::array<float, 3>{2, 3, 4}));
    ASSERT_EQ(ti_target_index(f).size(), 2U);
    EXPECT_EQ(ti_target_index(f)[1], 254);
    ASSERT_EQ(ti_linear_profile(f).size(), 2U);
    EXPECT_EQ(ti_linear_profile(f)[1], 5U);
  });
  std::vector<Item> both = packed;
  both.push_back(entries(1010, {numbered(27)}));
  both.push_back(item_of<std::uint8_t>(1011, {1}));
  both.push_back(item_of<std::uint32_t>(302, {6}));
  one_frame(frame(1, 0, both, 0x05050000, 0xA6432), [](const TiFrame& f) {
    EXPECT_EQ(ti_targets(f)[0].position_m, (std::array<float, 3>{1, 2, 3}));
    EXPECT_EQ(ti_target_index(f).size(), 1U);
    EXPECT_EQ(ti_linear_profile(f).size(), 1U);
  });
}

TEST(TiTracking, VitalSigns) {
  Item item = item_of<std::uint16_t>(1040, {2, 77});
  for (const float v : numbered(33)) append(item.payload, v);
  one_frame(frame(1, 0, {item}), [](const TiFrame& f) {
    const auto v = ti_vital_signs(f);
    ASSERT_TRUE(v);
    EXPECT_EQ(v->id, 2);
    EXPECT_EQ(v->range_bin, 77);
    EXPECT_EQ(v->breath_deviation, 1.0F);
    EXPECT_EQ(v->heart_per_min, 2.0F);
    EXPECT_EQ(v->breath_per_min, 3.0F);
    for (std::size_t i = 0; i < 15; ++i) {  // the numbers from the fourth and the 19th on
      EXPECT_EQ(v->heart_waveform[i], static_cast<float>(4 + i));
      EXPECT_EQ(v->breath_waveform[i], static_cast<float>(19 + i));
    }
  });
}

TEST(TiItems, ProfilesAndMaps) {
  const Stream bytes =
      frame(1, 0,
            {item_of<std::uint16_t>(2, {0, 512, 5120}), item_of<std::uint16_t>(3, {7}),
             item_of<std::int16_t>(8, {-1, 2, 3, -4}), item_of<std::uint16_t>(5, {9, 65'535})});
  one_frame(bytes, [](const TiFrame& f) {
    ASSERT_EQ(ti_range_profile(f).size(), 3U);
    EXPECT_EQ(ti_level_db(ti_range_profile(f)[0]), 0.0);
    // 512 are a factor of two in magnitude, 5120 one of 1024.
    EXPECT_NEAR(ti_level_db(ti_range_profile(f)[1]), 20.0 * std::log10(2.0), 1e-12);
    EXPECT_NEAR(ti_level_db(ti_range_profile(f)[2]), 20.0 * std::log10(1024.0), 1e-11);
    EXPECT_EQ(ti_noise_profile(f)[0], 7);
    ASSERT_EQ(ti_azimuth_map(f).size(), 4U);
    EXPECT_EQ(ti_azimuth_map(f)[3], -4);
    EXPECT_EQ(ti_range_doppler_map(f)[1], 65'535);
    EXPECT_EQ(ti_linear_profile(f).size(), 0U);
  });
  Item odd = item_of<std::uint16_t>(2, {1, 2});
  odd.payload.push_back(3);
  one_frame(frame(1, 0, {odd}),
            [](const TiFrame& f) { EXPECT_EQ(ti_range_profile(f).size(), 2U); });
}

TEST(TiTracking, UnitsThatAreNotNumbersGiveNoDecibels) {
  for (const float unit : {std::nanf(""), INFINITY, -INFINITY, -1.0F, 0.0F, 1e30F}) {
    Item item = item_of<float>(1020, {unit, unit, unit, unit, unit});
    for (int i = 0; i < 8; ++i) item.payload.push_back(0x7F);
    Item packed = item_of<float>(301, {unit, unit, unit, unit, 0.0F});
    for (int i = 0; i < 10; ++i) packed.payload.push_back(0x7F);
    for (const Item& i : {item, packed})
      one_frame(frame(1, 1, {i}), [&](const TiFrame& f) {
        const TiPoint p = f[0];
        EXPECT_LE(std::abs(p.snr_ddb), 30'000);
        EXPECT_LE(std::abs(p.noise_ddb), 30'000);
        for (const RadarPoint& r : to_radar_scan(f, LogTime{}).points)
          EXPECT_TRUE(std::isfinite(r.x_m) && std::isfinite(r.doppler_m_s));
      });
  }
}

TiRefusal refusal_of(const Stream& bytes) {
  const auto decoder = std::make_unique<TiDecoder>();
  const auto fail = [](const TiFrame&) { ADD_FAILURE(); };
  decoder->feed(bytes, fail);
  decoder->finish(fail);
  EXPECT_GE(decoder->statistics().malformed, 1U);
  return decoder->framing().refusal();
}

TEST(TiTracking, ARefusalNamesTheHeader) {
  EXPECT_EQ(to_string(TiRefusal{}), "");
  Item odd = compressed_points(1020, {kPoint});
  odd.payload.pop_back();
  const TiRefusal item = refusal_of(frame(7, 1, {odd}));
  EXPECT_EQ(item.fault, TiFault::item);
  EXPECT_THAT(to_string(item), HasSubstr("byte 0: recognised the demo's header of 40 bytes "
                                         "(version 3.6.0.0, platform A1843, frame 7"));
  EXPECT_THAT(to_string(item), HasSubstr("type 1020 has an impossible length"));

  const TiRefusal points = refusal_of(frame(7, 3, {float_points(2)}));
  EXPECT_THAT(to_string(points), HasSubstr("counts other points"));

  Item odd_of_tracker = odd;
  odd_of_tracker.type = 6;
  const TiRefusal tracker = refusal_of(tracker_3d_frame(9, {odd_of_tracker}));
  EXPECT_THAT(to_string(tracker), HasSubstr("48 bytes of 3D people counting"));

  Stream longer = frame(7, 1, {float_points(1)});
  longer[12] = 96;  // the header and a point use 64 bytes of which none is padding
  longer.resize(96 + 8);
  EXPECT_THAT(to_string(refusal_of(longer)), HasSubstr("do not end where the frame does"));

  Stream unknown = tracker_3d_frame(9, {});
  unknown[46] ^= 1;
  unknown[30] = 9;  // 600 000 us, which would be the demo's number of points
  const TiRefusal header = refusal_of(unknown);
  EXPECT_EQ(header.fault, TiFault::header);
  EXPECT_THAT(to_string(header), HasSubstr("of no known header"));
}

// 40 + 8 + 32 bytes, filled up to 96, behind five others; a point more is counted.
TEST(TiTracking, ARefusalInWords) {
  EXPECT_EQ(to_string(refusal_of(joined({Stream(5), frame(7, 3, {float_points(2)}, 0x03060201)}))),
            "byte 5: recognised the demo's header of 40 bytes (version 3.6.2.1, platform A1843, "
            "frame 7, 96 bytes, 1 items, 3 points): it counts other points than there are");
  EXPECT_THAT(to_string(refusal_of(frame(7, 3, {float_points(2)}, 0x03060201, 0xA1443))),
              HasSubstr("the demo's header of 36 bytes (version 3.6.2.1, platform A1443"));
  Item odd = item_of<float>(6, numbered(3));
  EXPECT_EQ(to_string(refusal_of(tracker_2d_frame(9, {odd}))),
            "byte 0: recognised the header of 52 bytes of people counting in a plane (version "
            "1.2.0.3, platform A1642, frame 9, 96 bytes, 1 items, 0 points): the item of type 6 "
            "has an impossible length");
  // A header of which 36 bytes precede the next frame.
  Stream cut = frame(7, 0, {});
  cut.resize(36);
  const auto decoder = std::make_unique<TiDecoder>();
  int frames = 0;
  decoder->feed(joined({cut, frame(8, 0, {})}), [&](const TiFrame&) { ++frames; });
  EXPECT_EQ(frames, 1);
  EXPECT_EQ(decoder->framing().refusal().fault, TiFault::length);
  EXPECT_THAT(to_string(decoder->framing().refusal()), HasSubstr("it ends within the header"));
}

testing::DecoderLaws<TiDecoder> laws_of(const Stream& stream) { return {stream, kAsText}; }

TEST(TiTracking, LawsOfTheLayouts) {
  std::vector<Stream> streams(4);
  for (std::uint32_t i = 1; i <= 12; ++i) {
    const std::vector<CompressedPoint> points(i % 5, kPoint);
    const auto n = static_cast<std::uint32_t>(points.size());
    append(streams[0],
           frame(i, n, {compressed_points(1020, points), entries(1010, {numbered(27)})}));
    append(streams[1], tracker_3d_frame(i, {compressed_points(6, points)}));
    append(streams[2], tracker_2d_frame(i, {item_of<float>(6, numbered(4 * n))}));
    append(streams[3],
           area_frame(i, n, 0, {item_of<float>(1, numbered(4 * n)), entries(10, {numbered(9)})}));
  }
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const auto laws = laws_of(streams[i]);
    laws.check();
    const testing::DamageReport report = laws.damage(500);
    report.record("layout_" + std::to_string(i));
    EXPECT_EQ(report.lost, 0U) << i;
  }
}

}  // namespace
}  // namespace wayfare::decode
