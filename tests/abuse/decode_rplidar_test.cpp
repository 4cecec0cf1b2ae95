// An RPLIDAR's packets, points and scans at their edges.
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/decode/rplidar_stream.hpp>

#include "abuse/abuse.hpp"
#include "abuse/decode_streams.hpp"

namespace wayfare::decode {
namespace {

using tests::Stream;

TEST(RplidarAbuse, AStreamInsideNoScanIsSearchedForADescriptor) {
  using enum RplidarResponse;
  for (const RplidarResponse inside : {none, info, health, sample_rate, conf, conf_set, board_flags,
                                       static_cast<RplidarResponse>(0x33)}) {
    RplidarDecoder decoder{RplidarFraming(inside)};
    std::vector<std::size_t> lengths;
    const auto sink = [&](const RplidarPacket& p) { lengths.push_back(p.bytes().size()); };
    Stream bytes(10, 7);
    tests::append(bytes, tests::rplidar_descriptor_of(health, 3, false));
    tests::append(bytes, {0, 0, 0});
    decoder.feed(bytes, sink);
    decoder.finish(sink);
    EXPECT_EQ(lengths, (std::vector<std::size_t>{7, 3}));
  }
}

TEST(RplidarAbuse, AReplyCutByTheEndOfTheStreamHasNoPartInTheNext) {
  using enum RplidarResponse;
  const Stream info_then_nothing = tests::rplidar_descriptor_of(info, 20, false);
  for (const std::size_t present : {std::size_t{0}, std::size_t{1}, std::size_t{19}}) {
    RplidarDecoder decoder;
    std::vector<RplidarResponse> replies;
    const auto sink = [&](const RplidarPacket& p) {
      if (!p.is_descriptor()) replies.push_back(p.response());
    };
    decoder.feed(info_then_nothing, sink);
    decoder.feed(Stream(present, 1), sink);
    decoder.finish(sink);
    Stream next = tests::rplidar_descriptor_of(health, 3, false);
    tests::append(next, {0, 0, 0});
    decoder.feed(next, sink);
    decoder.finish(sink);
    EXPECT_EQ(replies, std::vector<RplidarResponse>{health}) << present;
  }
}

TEST(RplidarAbuse, AnglesStayBelowAFullCircle) {
  // A capsule that spans almost a turn, of points so near that their correction adds 20°.
  Rng rng(1);
  for (int trial = 0; trial < 300; ++trial) {
    const int start = trial == 0 ? 359 * 64 : static_cast<int>(rng.below(0x8000));
    const int next = trial == 0 ? 358 * 64 : static_cast<int>(rng.below(0x8000));
    Stream contents(128);
    for (auto& byte : contents) byte = static_cast<std::uint8_t>(rng());
    // Distances of 50 mm: the base, and no differences from it.
    if (trial % 2 == 0)
      for (std::size_t i = 0; i < 128; i += 4) store_le(std::uint32_t{50}, &contents[i]);
    Stream bytes = tests::rplidar_capsule(start, contents);
    tests::append(bytes, tests::rplidar_capsule(next, contents));
    RplidarDecoder decoder{RplidarFraming(RplidarResponse::ultra)};
    RplidarUnpacker unpacker;
    std::size_t points = 0;
    decoder.feed(bytes, [&](const RplidarPacket& p) {
      unpacker.add(p, [&](std::span<const RplidarPoint> some) {
        for (const RplidarPoint& point : some) {
          ++points;
          ASSERT_LT(point.angle_q6, 360 * 64) << trial;
          ASSERT_LT(point.angle_deg(), 360.0);
        }
      });
    });
    EXPECT_EQ(points, 96U);
  }
}

TEST(RplidarAbuse, PacketsOfNoScanGiveNoPoints) {
  RplidarUnpacker unpacker;
  const auto fail = [](std::span<const RplidarPoint>) { FAIL(); };
  const Stream bytes(781, 0x5A);
  unpacker.add(RplidarPacket{}, fail);
  for (int response = 0; response < 256; ++response)
    for (const std::size_t n : {0U, 4U, 6U, 83U, 84U, 85U, 131U, 132U, 169U, 170U, 780U, 781U})
      for (std::uint64_t position : {0U, 84U}) {
        const auto r = static_cast<RplidarResponse>(response);
        if (r != RplidarResponse::node && n != 0 && n == rplidar_packet_bytes(r)) continue;
        unpacker.add(RplidarPacket(r, false, position, Bytes(bytes).first(n)), fail);
      }
}

RplidarRevolution revolution_of(const std::vector<TimedRplidarPoint>& points) {
  return {points, true};
}

TEST(RplidarAbuse, ScansWithoutBeamsAndWithoutPoints) {
  const std::vector<TimedRplidarPoint> points = {{{64 * 90, 4000, 10, true}, LogTime{}}};
  EXPECT_TRUE(to_laser_scan(revolution_of(points), {0}).ranges_m.empty());
  const LaserScan one = to_laser_scan(revolution_of(points), {1});
  ASSERT_EQ(one.ranges_m.size(), 1U);
  EXPECT_EQ(one.ranges_m[0], 1.0F);
  const LaserScan none = to_laser_scan({}, {4});
  EXPECT_EQ(none.ranges_m.size(), 4U);
  EXPECT_FALSE(none.returned(0));
}

TEST(RplidarAbuse, NoReturnIsNoRangeWhateverTheLimits) {
  const std::vector<TimedRplidarPoint> points = {{{64 * 90, 0, 0, true}, LogTime{}},
                                                 {{64 * 180, 2, 0, false}, LogTime{}}};
  for (const float least : {0.0F, -1.0F, -std::numeric_limits<float>::infinity()}) {
    const LaserScan scan = to_laser_scan(revolution_of(points), {4, least, 12.0F});
    EXPECT_TRUE(std::isnan(scan.ranges_m[1])) << "bearing -90 degrees has no return";
    EXPECT_EQ(scan.ranges_m[0], 0.0005F);
  }
  for (const double bad : {tests::kNan, tests::kInf}) {
    const LaserScan scan =
        to_laser_scan(revolution_of(points), {4, static_cast<float>(bad), 12.0F});
    for (const float range : scan.ranges_m) EXPECT_TRUE(std::isnan(range));
  }
}

TEST(RplidarAbuse, AnAngleBeyondTheCircleIsTakenModuloTheCircle) {
  for (const int turns : {0, 1, 2}) {
    const auto angle = static_cast<std::uint16_t>(64 * (10 + 360 * turns));
    const LaserScan scan =
        to_laser_scan(revolution_of({{{angle, 4000, 0, true}, LogTime{}}}), {36});
    EXPECT_EQ(scan.ranges_m[17], 1.0F) << turns;
  }
  static_cast<void>(to_laser_scan(revolution_of({{{0xFFFF, 0xFFFFFFFF, 0, true}, LogTime{}}})));
}

TEST(RplidarAbuse, ASampleRateOfZeroIsNoRate) {
  // The points of a capsule keep the times of an A1, 250 µs apart.
  RplidarStream stream(115200);
  Stream bytes = tests::rplidar_descriptor_of(RplidarResponse::sample_rate, 4, false);
  tests::append(bytes, {0, 0, 0, 0});
  tests::append(bytes, tests::rplidar_descriptor_of(RplidarResponse::express, 84, true));
  for (int i = 0; i < 40; ++i)
    tests::append(bytes, tests::rplidar_capsule(i * 1920 % (360 * 64), Stream(80, 0x10)));
  std::size_t revolutions = 0;
  stream.feed(bytes, LogTime::from_seconds(1e9), [&](const RplidarRevolution& r) {
    ++revolutions;
    ASSERT_GT(r.points.size(), 300U);
    EXPECT_EQ(r.points[11].time - r.points[10].time, std::chrono::microseconds(250));
  });
  EXPECT_GE(revolutions, 2U);
  EXPECT_EQ(rplidar_delay(RplidarResponse::node, Duration(0), 1e9), Duration(50));
}

TEST(RplidarAbuse, RevolutionsWithoutRoomOrPoints) {
  RplidarRevolutions<1> tiny;
  std::size_t whole = 0;
  const auto sink = [&](const RplidarRevolution& r) { whole += r.whole ? 1 : 0; };
  tiny.add({}, LogTime{}, Duration(1), sink);
  tiny.finish(sink);
  const std::array<RplidarPoint, 3> points = {{{0, 1, 0, true}, {1, 1, 0, true}, {2, 1, 0, true}}};
  tiny.add(points, LogTime::from_seconds(-1e9), Duration(-5), sink);
  tiny.finish(sink);
  EXPECT_EQ(whole, 2U) << "a revolution of a single point each";
  EXPECT_EQ(tiny.dropped_points(), 0U);
}

TEST(RplidarAbuse, RepliesOfOtherLengths) {
  for (std::size_t n = 0; n < 64; ++n) {
    const Stream bytes(n);
    EXPECT_EQ(rplidar_info(bytes).has_value(), n == 20);
    EXPECT_EQ(rplidar_health(bytes).has_value(), n == 3);
    EXPECT_EQ(rplidar_sample_rate(bytes).has_value(), n == 4);
    EXPECT_EQ(rplidar_conf(bytes).has_value(), n >= 4);
    EXPECT_FALSE(rplidar_descriptor(bytes));
    EXPECT_EQ(rplidar_chain(bytes, 0), 0U);
    EXPECT_EQ(rplidar_chain(bytes, n + 100), 0U);
  }
  // Every length of every type: known or refused.
  for (int type = 0; type < 256; ++type)
    for (const std::uint32_t length : {0U, 1U, 5U, 84U, 255U, 256U, 0x3FFFFFFFU})
      for (const bool endless : {false, true}) {
        const auto d = rplidar_descriptor(
            tests::rplidar_descriptor_of(static_cast<RplidarResponse>(type), length, endless));
        EXPECT_TRUE(!d || (d->length == length && length <= 255 && length > 0));
      }
}

}  // namespace
}  // namespace wayfare::decode
