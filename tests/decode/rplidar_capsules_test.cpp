// HQ and ultra-dense capsules, and settings. There is no capture of them: they are encoded here by
// the layouts of the maker's SDK (sl_lidar_cmd.h), and compared with the points they were made of.
#include <wayfare/decode/rplidar_conf.hpp>

#include <chrono>
#include <string_view>

#include <wayfare/decode/detail/crc32.hpp>
#include <wayfare/decode/rplidar_packet.hpp>
#include <wayfare/decode/rplidar_scan.hpp>

#include "rplidar_streams.hpp"

namespace wayfare::decode {
namespace {

TEST(RplidarConfTest, RequestsAndResponses) {
  // A5 ^ 85 ^ 06 ^ 01 ^ 58 ^ 02 = 7D: 600 revolutions per minute.
  const auto rotation = rplidar_set_conf(RplidarConfKey::desired_rotation, Stream{0x58, 0x02});
  ASSERT_TRUE(rotation);
  EXPECT_EQ(hex(rotation->bytes()),
            "A5850601000000"
            "58027D");
  EXPECT_FALSE(rplidar_set_conf(RplidarConfKey::static_ip_address, Stream(57)));
  EXPECT_TRUE(rplidar_set_conf(RplidarConfKey::static_ip_address, Stream(56)));
  const RplidarRequest hq = rplidar_hq_scan();
  EXPECT_EQ(hex(hq.bytes()), "A58321" + std::string(66, '0') + "07");
  const auto set = rplidar_conf_set(Stream{0x01, 0, 0, 0, 0x02, 0x80, 0, 0});
  ASSERT_TRUE(set);
  EXPECT_EQ(set->key, RplidarConfKey::desired_rotation);
  EXPECT_EQ(set->result, 0x8002U);
  EXPECT_FALSE(rplidar_conf_set(Stream(7)));
}

// 1/256 µs: 254 µs are 0xFE00; more than none and less than a second, 256 · 10⁶ = 0x0F424000.
TEST(RplidarConfTest, TheTimeOfASample) {
  const auto sample = [](const Stream& value, RplidarConfKey key) {
    return rplidar_mode_sample({key, value});
  };
  constexpr auto kKey = RplidarConfKey::mode_sample_us;
  EXPECT_EQ(sample({0x00, 0xFE, 0, 0}, kKey), std::chrono::microseconds(254));
  EXPECT_EQ(sample({1, 0, 0, 0}, kKey), Duration(3));                        // 3.9 ns, cut off
  EXPECT_EQ(sample({0xFF, 0x3F, 0x42, 0x0F}, kKey), Duration(999'999'996));  // 999999996.1 ns
  EXPECT_FALSE(sample({0x00, 0x40, 0x42, 0x0F}, kKey));
  EXPECT_FALSE(sample({0, 0, 0, 0}, kKey));
  EXPECT_FALSE(sample({0x00, 0xFE, 0}, kKey));
  EXPECT_FALSE(sample({0x00, 0xFE, 0, 0}, RplidarConfKey::mode_max_distance));
}

TEST(RplidarConfTest, ItsResponseIsFramed) {
  Stream bytes = descriptor(RplidarResponse::conf_set, 8, false);
  append(bytes, {0xC0, 0xCC, 0x01, 0, 0, 0, 0, 0});
  RplidarDecoder decoder;
  int seen = 0;
  decoder.feed(bytes, [&](const RplidarPacket& p) {
    if (p.is_descriptor()) return;
    ++seen;
    EXPECT_EQ(rplidar_conf_set(p.bytes())->key, RplidarConfKey::static_ip_address);
  });
  EXPECT_EQ(seen, 1);
}

TEST(RplidarHq, TheChecksumIsThatOfTheStandard) {
  // The check value of CRC-32/ISO-HDLC.
  const std::string_view text = "123456789";
  const Stream bytes(text.begin(), text.end());
  EXPECT_EQ(detail::crc32(bytes), 0xCBF43926U);
  EXPECT_EQ(detail::crc32(Bytes(bytes).subspan(4), detail::crc32(Bytes(bytes).first(4))),
            0xCBF43926U);
}

TEST(RplidarHq, PointsKeepTheirAngleDistanceAndQuality) {
  std::vector<HqNode> nodes(96);
  for (std::size_t i = 0; i < 96; ++i)
    nodes[i] = {static_cast<std::uint16_t>(683 * i + 1), static_cast<std::uint32_t>(400'000 + i),
                static_cast<std::uint8_t>(160 + i), static_cast<std::uint8_t>(i == 7 ? 1 : 2)};
  nodes[95].angle_z_q14 = 0xFFFF;
  Stream bytes = descriptor(RplidarResponse::hq, 781, true);
  append(bytes, hq_capsule(nodes));
  const Points points = points_of(bytes);
  ASSERT_EQ(points.size(), 96U);
  for (std::size_t i = 0; i < 96; ++i) {
    EXPECT_EQ(points[i].angle_z_q14(), nodes[i].angle_z_q14) << "the device's angle is restored";
    EXPECT_EQ(points[i].angle_deg(), nodes[i].angle_z_q14 * 90.0 / 16384.0);
    EXPECT_LT(points[i].angle_q6, 360 * 64);
    EXPECT_EQ(points[i].distance_q2, nodes[i].distance_q2);
    EXPECT_EQ(points[i].quality, nodes[i].quality);
    EXPECT_EQ(points[i].start_of_revolution, i == 7);
  }
}

TEST(RplidarHq, AWrongChecksumIsRefusedAndTheNextCapsuleFound) {
  const std::vector<HqNode> nodes(96, {100, 4000, 50, 2});
  Stream bytes = descriptor(RplidarResponse::hq, 781, true);
  for (int i = 0; i < 3; ++i) append(bytes, hq_capsule(nodes));
  bytes[7 + 781 + 300] ^= 1;
  RplidarDecoder decoder;
  std::size_t capsules = 0;
  decoder.feed(bytes, [&](const RplidarPacket& p) { capsules += p.is_descriptor() ? 0 : 1; });
  EXPECT_EQ(capsules, 2U);
  EXPECT_GE(decoder.statistics().checksum_failures, 1U);
  EXPECT_EQ(decoder.statistics().skipped_bytes, 781U);
}

// Capsules a quarter of a turn apart: their 64 points are 90/64 degrees apart.
TEST(RplidarUltraDense, DistancesOfAllScales) {
  // Units of each scale are 2, 3, 4 and 5 mm; each begins where the one before ends, at 0, 2046,
  // 8187 and 24567 mm, so that these are the distances in mm:
  struct Case {
    int scale;
    unsigned units, quality;
    std::uint32_t mm;
    int shown;  // quality, of which coarse scales omit the lowest bits
  };
  const std::vector<Case> cases = {{0, 500, 200, 1000, 200},  {1, 318, 100, 3000, 200},
                                   {2, 453, 50, 9999, 200},   {3, 3087, 25, 40002, 200},
                                   {3, 8191, 31, 65522, 248}, {0, 0, 0, 0, 0},
                                   {0, 1023, 255, 2046, 255}, {1, 0, 0, 2046, 0}};
  std::vector<std::uint32_t> codes;
  for (std::size_t i = 0; i < 64; ++i) {
    const Case& c = cases[i % cases.size()];
    codes.push_back(ultra_dense_code(c.scale, c.units, c.quality));
  }
  Stream bytes = descriptor(RplidarResponse::ultra_dense, 170, true);
  append(bytes, ultra_dense_capsule(300 * 64, codes, true));
  append(bytes, ultra_dense_capsule(30 * 64, codes));
  const Points points = points_of(bytes);
  ASSERT_EQ(points.size(), 64U);
  for (std::size_t i = 0; i < 64; ++i) {
    const Case& c = cases[i % cases.size()];
    EXPECT_EQ(points[i].distance_q2, 4 * c.mm) << i;
    EXPECT_EQ(points[i].quality, c.shown) << i;
    const int angle_q6 = (300 * 64 + static_cast<int>(i) * 90) % (360 * 64);
    EXPECT_EQ(points[i].angle_q6, angle_q6) << i;
  }
  // 360 degrees are 42.67 steps of 90/64 from 300: the first angle above is the 44th, and the
  // maker's rule flags the point before it.
  for (std::size_t i = 0; i < 64; ++i) EXPECT_EQ(points[i].start_of_revolution, i == 42) << i;
}

TEST(RplidarUltraDense, NearDistancesAreAveragedWithTheOneBefore) {
  // 1000, 1002, 1004 mm in units of 2 mm: within 2 mm of the (averaged) one before.
  std::vector<std::uint32_t> codes(64, ultra_dense_code(0, 100, 9));
  for (unsigned i = 0; i < 3; ++i) codes[i] = ultra_dense_code(0, 500 + i, 9);
  Stream bytes = descriptor(RplidarResponse::ultra_dense, 170, true);
  append(bytes, ultra_dense_capsule(0, codes, true));
  append(bytes, ultra_dense_capsule(20 * 64, codes));
  const Points points = points_of(bytes);
  ASSERT_EQ(points.size(), 64U);
  EXPECT_EQ(points[0].distance_q2, 4000U);
  EXPECT_EQ(points[1].distance_q2, 4004U);  // (4008 + 4000) / 2
  EXPECT_EQ(points[2].distance_q2, 4016U);  // 12 above: not near
  EXPECT_EQ(points[3].distance_q2, 800U);
}

TEST(RplidarUltraDense, ADamagedCapsuleAffectsOnlyItsNeighbour) {
  const std::vector<std::uint32_t> codes(64, ultra_dense_code(1, 50, 10));
  Stream bytes = descriptor(RplidarResponse::ultra_dense, 170, true);
  for (int i = 0; i < 6; ++i) append(bytes, ultra_dense_capsule(640 * (i + 1), codes, i == 0));
  EXPECT_EQ(points_of(bytes).size(), 5 * 64U);
  bytes[7 + 170 * 2 + 50] ^= 4;
  EXPECT_EQ(points_of(bytes).size(), 3 * 64U);
}

TEST(RplidarCapsules, APacketOfAnotherLengthGivesNoPoints) {
  RplidarUnpacker unpacker;
  const Stream bytes(800, 0xA5);
  for (const auto response : {RplidarResponse::hq, RplidarResponse::ultra_dense})
    for (const std::size_t n : {0U, 1U, 84U, 169U, 171U, 780U, 782U})
      unpacker.add(RplidarPacket(response, false, 0, Bytes(bytes).first(n)),
                   [](std::span<const RplidarPoint>) { FAIL(); });
}

}  // namespace
}  // namespace wayfare::decode
