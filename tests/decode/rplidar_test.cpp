#include <wayfare/decode/rplidar_decoder.hpp>

#include <chrono>
#include <memory>

#include <wayfare/decode/rplidar_conf.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/decode/rplidar_sweep.hpp>

#include "captures.hpp"
#include "rplidar_streams.hpp"

namespace wayfare::decode {
namespace {

TEST(Rplidar, RequestsMatchTheManual) {
  EXPECT_EQ(hex(rplidar_stop().bytes()), "A525");
  EXPECT_EQ(hex(rplidar_reset().bytes()), "A540");
  EXPECT_EQ(hex(rplidar_scan().bytes()), "A520");
  EXPECT_EQ(hex(rplidar_scan(true).bytes()), "A521");
  EXPECT_EQ(hex(rplidar_express_scan().bytes()),
            "A582050000000000"
            "22");
  EXPECT_EQ(hex(rplidar_get_info().bytes()), "A550");
  EXPECT_EQ(hex(rplidar_get_health().bytes()), "A552");
  EXPECT_EQ(hex(rplidar_get_sample_rate().bytes()), "A559");
  // A5 ^ F0 ^ 02 ^ 94 ^ 02 = C1: 660 of 1023, the makers' default.
  EXPECT_EQ(hex(rplidar_motor_pwm(660).bytes()), "A5F0029402C1");
  EXPECT_EQ(hex(rplidar_motor_speed(600).bytes()),
            "A5A8025802"
            "55");
  EXPECT_EQ(hex(rplidar_get_conf(RplidarConfKey::mode_count).bytes()),
            "A5840470000000"
            "55");
  EXPECT_EQ(hex(rplidar_get_conf(RplidarConfKey::mode_name, 2).bytes()),
            "A584067F0000000200"
            "5A");
}

TEST(Rplidar, SingleAnswers) {
  Stream bytes = descriptor(RplidarResponse::info, 20, false);
  append(bytes, {0x18, 29, 1, 7, 0xAA, 0xBB, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xCC});
  append(bytes, descriptor(RplidarResponse::health, 3, false));
  append(bytes, {1, 0x34, 0x12});
  append(bytes, descriptor(RplidarResponse::sample_rate, 4, false));
  append(bytes, {0xFC, 0x01, 0xFE, 0x00});
  append(bytes, descriptor(RplidarResponse::conf, 5, false));
  append(bytes, {0x75, 0, 0, 0, 0x84});
  RplidarDecoder decoder;
  int seen = 0;
  const auto sink = [&](const RplidarPacket& p) {
    if (p.is_descriptor()) return;
    ++seen;
    if (p.response() == RplidarResponse::info) {
      const auto info = rplidar_info(p.bytes());
      ASSERT_TRUE(info);
      EXPECT_EQ(info->model, 0x18);
      EXPECT_EQ(info->firmware_major, 1);
      EXPECT_EQ(info->firmware_minor, 29);
      EXPECT_EQ(info->hardware, 7);
      EXPECT_EQ(info->serial[15], 0xCC);
    } else if (p.response() == RplidarResponse::health) {
      const auto health = rplidar_health(p.bytes());
      ASSERT_TRUE(health);
      EXPECT_EQ(health->status, RplidarHealth::Status::warning);
      EXPECT_EQ(health->code, 0x1234);
    } else if (p.response() == RplidarResponse::sample_rate) {
      const auto rate = rplidar_sample_rate(p.bytes());
      ASSERT_TRUE(rate);
      EXPECT_EQ(rate->standard_us, 508);
      EXPECT_EQ(rate->express_us, 254);
    } else {
      const auto conf = rplidar_conf(p.bytes());
      ASSERT_TRUE(conf);
      EXPECT_EQ(conf->key, RplidarConfKey::mode_response);
      EXPECT_EQ(conf->value[0], 0x84);
    }
  };
  decoder.feed(bytes, sink);
  EXPECT_EQ(seen, 4);
  EXPECT_EQ(decoder.statistics().skipped_bytes, 0U);
  EXPECT_FALSE(rplidar_health(Stream{3, 0, 0}));
  EXPECT_FALSE(rplidar_info(Stream(19)));
  EXPECT_FALSE(rplidar_sample_rate(Stream(3)));
  EXPECT_FALSE(rplidar_conf(Stream(3)));
}

TEST(Rplidar, Nodes) {
  Stream bytes = descriptor(RplidarResponse::node, 5, true);
  append(bytes, node(64, 4000, 47, true));
  append(bytes, node(128, 0, 0));
  EXPECT_EQ(points_of(bytes), (Points{{64, 4000, 47, true}, {128, 0, 0, false}}));
  EXPECT_EQ(points_of(bytes)[0].distance_m(), 1.0);
  EXPECT_EQ(points_of(bytes)[0].angle_deg(), 1.0);
}

TEST(Rplidar, ARestartInsideANode) {
  for (std::size_t cut = 0; cut <= 5; ++cut) {
    Stream bytes = descriptor(RplidarResponse::node, 5, true);
    for (int i = 0; i < 20; ++i) append(bytes, node(64 * i, 4000 + i));
    const Stream old = node(64 * 20, 4020);
    bytes.insert(bytes.end(), old.begin(), old.begin() + static_cast<long>(cut));
    append(bytes, {0xA5, 0x25, 0xFF, 0xFF, 0xA5, 0x52, 0xA5, 0x20});
    append(bytes, descriptor(RplidarResponse::health, 3, false));
    append(bytes, {0, 0, 0});
    append(bytes, descriptor(RplidarResponse::node, 5, true));
    for (int i = 0; i < 20; ++i) append(bytes, node(6400 + 64 * i, 8000 + i));
    const Points points = points_of(bytes);
    ASSERT_GE(points.size(), 40U) << cut;
    // One node composed of the rest of the last one and the descriptor may precede it.
    EXPECT_LE(points.size(), 42U) << cut;
    for (std::size_t i = 0; i < 20; ++i) {
      EXPECT_EQ(points[i].distance_q2, 4000 + i);
      EXPECT_EQ(points[points.size() - 20 + i].distance_q2, 8000 + i);
    }
  }
}

TEST(Rplidar, NodesAreFoundAfterALostByte) {
  for (std::size_t lost = 1; lost < 9; ++lost) {
    Stream bytes = descriptor(RplidarResponse::node, 5, true);
    for (int i = 0; i < 60; ++i) append(bytes, node(64 * i, 4001 + i));
    const auto at = bytes.begin() + 7 + 5 * 30 + 2;
    bytes.erase(at, at + static_cast<long>(lost));
    const Points points = points_of(bytes);
    // Every whole node is found.
    const std::size_t damaged = lost <= 3 ? 1 : 2;
    for (std::size_t i = 0; i < 60; ++i) {
      if (i >= 30 && i < 30 + damaged) continue;
      const auto found = std::count_if(points.begin(), points.end(), [i](const RplidarPoint& p) {
        return p.angle_q6 == 64 * i && p.distance_q2 == 4001 + i;
      });
      EXPECT_EQ(found, 1) << i << ", " << lost << " bytes lost";
    }
    EXPECT_LE(points.size(), 61 - damaged) << lost;
  }
}

// Encoded here from known points; the comments give the results of the maker's arithmetic.
TEST(Rplidar, ExpressCapsule) {
  Stream contents, empty(80);
  for (int i = 0; i < 16; ++i) {
    const int d1 = (1000 + i) << 2 | 1, d2 = 0;  // millimetres; top two bits of the first offset
    append(contents, {static_cast<std::uint8_t>(d1), static_cast<std::uint8_t>(d1 >> 8),
                      static_cast<std::uint8_t>(d2), static_cast<std::uint8_t>(d2 >> 8), 0x30});
  }
  Stream bytes = descriptor(RplidarResponse::express, 84, true);
  append(bytes, capsule(350 * 64, contents, true));
  append(bytes, capsule(22 * 64, empty));
  const Points points = points_of(bytes);
  ASSERT_EQ(points.size(), 32U);
  // 32° in 32 steps; the first of a pair is 16/8 = 2° before its nominal angle, the second 3/8°.
  EXPECT_EQ(points[0], (RplidarPoint{348 * 64, 4000, 47, false}));
  EXPECT_EQ(points[1], (RplidarPoint{351 * 64 - 24, 0, 0, false}));
  EXPECT_EQ(points[10], (RplidarPoint{358 * 64, 4020, 47, false}));
  // The revolution ends where the nominal angle reaches 360°: with the tenth.
  for (std::size_t i = 0; i < 32; ++i) EXPECT_EQ(points[i].start_of_revolution, i == 9) << i;
}

TEST(Rplidar, DenseCapsule) {
  Stream contents;
  for (int i = 0; i < 40; ++i)
    append(contents,
           {static_cast<std::uint8_t>(2000 + i), static_cast<std::uint8_t>((2000 + i) >> 8)});
  Stream bytes = descriptor(RplidarResponse::dense, 84, true);
  append(bytes, capsule(10 * 64, contents, true));
  append(bytes, capsule(30 * 64, contents));
  append(bytes, capsule(50 * 64, contents));
  const Points points = points_of(bytes);
  ASSERT_EQ(points.size(), 80U);
  for (std::size_t i = 0; i < 40; ++i)  // half a degree apart
    EXPECT_EQ(points[i], (RplidarPoint{static_cast<std::uint16_t>(640 + 32 * i),
                                       static_cast<std::uint32_t>(8000 + 4 * i), 47, false}));
}

TEST(Rplidar, ADamagedCapsuleAffectsOnlyItsNeighbour) {
  Stream bytes = descriptor(RplidarResponse::dense, 84, true);
  for (int i = 0; i < 6; ++i) append(bytes, capsule(640 * (i + 1), Stream(80, 1), i == 0));
  EXPECT_EQ(points_of(bytes).size(), 200U);
  Stream flipped = bytes;
  flipped[7 + 84 * 2 + 50] ^= 4;
  EXPECT_EQ(points_of(flipped).size(),
            120U);  // 0 and 1 give the points of 0; 3 to 5 those of 3 and 4
  Stream restarted = bytes;
  restarted[7 + 84 * 3 + 3] |= 0x80;  // the encoder was reset
  restarted[7 + 84 * 3 + 1] ^= 0x08;
  EXPECT_EQ(points_of(restarted).size(), 160U);
}

TEST(Rplidar, RevolutionsAndScans) {
  std::vector<std::pair<std::size_t, bool>> revolutions;
  RplidarRevolutions<100> assembler;
  LaserScan scan;
  const auto sink = [&](const RplidarRevolution& revolution) {
    revolutions.emplace_back(revolution.points.size(), revolution.whole);
    if (revolutions.size() == 2) {
      EXPECT_EQ(revolution.points[1].time - revolution.points[0].time,
                std::chrono::microseconds(500));
      scan = to_laser_scan(revolution, {36, 0.15F, 12.0F});
    }
  };
  const Duration sample = std::chrono::microseconds(500);
  int measured = 0;
  for (int i = 5; i < 36 * 3 + 7; ++i) {
    const bool start = i % 36 == 0;
    const RplidarPoint p{static_cast<std::uint16_t>(640 * (i % 36)),
                         static_cast<std::uint32_t>(4000 + 40 * (i % 36)), 10, start};
    assembler.add({&p, 1}, LogTime{} + sample * measured++, sample, sink);
  }
  assembler.finish(sink);
  EXPECT_EQ(revolutions, (std::vector<std::pair<std::size_t, bool>>{
                             {31, false}, {36, true}, {36, true}, {7, false}}));
  // 90° clockwise of the front is 90° to the right: bearing −π/2, a quarter from the back.
  EXPECT_NEAR(scan.ranges_m[9], 1.09F, 1e-6F);
  EXPECT_NEAR(scan.bearing(9).radians(), -std::numbers::pi / 2.0, 1e-12);
  EXPECT_NEAR(scan.ranges_m[0], 1.18F, 1e-6F);   // behind
  EXPECT_NEAR(scan.ranges_m[18], 1.00F, 1e-6F);  // ahead
  EXPECT_EQ(scan.time, LogTime{} + sample * 31);
}

// 36 points from 355° on, 10° and 5 ms apart, at distances by their angles.
TEST(Rplidar, ASweepHasTheTimesOfItsPoints) {
  std::vector<TimedRplidarPoint> points;
  for (int i = 0; i < 36; ++i) {
    const int deg = (355 + 10 * i) % 360;
    points.push_back({{static_cast<std::uint16_t>(64 * deg),
                       static_cast<std::uint32_t>(4000 + 4 * deg), 10, i == 0},
                      LogTime{} + std::chrono::milliseconds(5 * i)});
  }
  const RplidarRevolution revolution{points, true};
  const LaserScan sweep = to_laser_sweep(revolution, {72, 0.15F, 12.0F});
  ASSERT_EQ(sweep.ranges_m.size(), 72U);
  EXPECT_NEAR(to_seconds(sweep.time_increment), -0.0025, 1e-9);
  for (std::size_t i = 0; i < 36; ++i) {
    const double deg = static_cast<double>(i) * 10.0 - 5.0;  // clockwise, from before 0 on
    const double beam = 71.0 - deg / 5.0;
    if (beam > 71.0) continue;  // before the first beam
    const auto at = static_cast<std::size_t>(std::lround(beam));
    EXPECT_NEAR(sweep.bearing(at).degrees(), -deg, 1e-9);
    EXPECT_NEAR(sweep.ranges_m[at], 1.0 + 1e-3 * deg, 1e-6);
    EXPECT_NEAR(to_seconds(sweep.beam_time(at) - points[i].time), 0.0, 1e-7) << i;
  }
  // The same points as without times.
  const LaserScan scan = to_laser_scan(revolution, {72, 0.15F, 12.0F});
  const auto returned = [](const LaserScan& s) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < s.ranges_m.size(); ++i) n += s.returned(i) ? 1 : 0;
    return n;
  };
  EXPECT_EQ(returned(sweep), returned(scan) - 1);  // 355° at the beginning is outside
}

TEST(Rplidar, ASweepWithoutAQuarterOfATurnHasNoTimes) {
  const TimedRplidarPoint point{{640, 4000, 10, true}, LogTime::from_seconds(1.0)};
  const LaserScan one = to_laser_sweep({{&point, 1}, true});
  EXPECT_FALSE(one.is_sweep());
  EXPECT_EQ(one.time, point.time);
  EXPECT_TRUE(to_laser_sweep({}).ranges_m.empty());
  EXPECT_TRUE(to_laser_sweep({{&point, 1}, true}, {0}).ranges_m.empty());
}

TEST(Rplidar, ARevolutionBeyondTheCapacityIsNotWhole) {
  RplidarRevolutions<10> assembler;
  std::size_t whole = 0, revolutions = 0;
  const auto sink = [&](const RplidarRevolution& revolution) {
    ++revolutions;
    whole += revolution.whole ? 1 : 0;
    EXPECT_LE(revolution.points.size(), 10U);
  };
  for (int i = 0; i < 60; ++i) {
    const RplidarPoint p{0, 0, 0, i % 20 == 0};
    assembler.add({&p, 1}, LogTime{}, Duration(1), sink);
  }
  EXPECT_EQ(revolutions, 2U);
  EXPECT_EQ(whole, 0U);
  EXPECT_EQ(assembler.dropped_points(), 30U);
}

/// Turns of 36 points, 10 degrees apart; those at `without` and `with` lack the mark of a start or
/// have one. The whole revolutions' numbers of points.
std::vector<std::size_t> whole_turns(int points, int without, int with) {
  std::vector<std::size_t> whole;
  RplidarRevolutions<200> assembler;
  const auto sink = [&](const RplidarRevolution& r) {
    if (r.whole) whole.push_back(r.points.size());
  };
  for (int i = 0; i < points; ++i) {
    const bool start = (i % 36 == 0 && i != without) || i == with;
    const RplidarPoint p{static_cast<std::uint16_t>(640 * (i % 36)), 4000, 10, start};
    assembler.add({&p, 1}, LogTime{}, Duration(1), sink);
  }
  return whole;
}

TEST(Rplidar, AStartInMidTurnIsNone) {
  const std::vector<std::size_t> three(3, 36);
  EXPECT_EQ(whole_turns(36 * 4, -1, -1), three);
  EXPECT_EQ(whole_turns(36 * 4, -1, 36 + 18), three);
  EXPECT_EQ(whole_turns(36 * 4, 0, 18), std::vector<std::size_t>(2, 36)) << "from 180 degrees on";
}

TEST(Rplidar, TwoTurnsAreNoRevolution) {
  EXPECT_EQ(whole_turns(36 * 5, 72, -1), (std::vector<std::size_t>{36, 36}));
}

TEST(Rplidar, Delays) {
  using std::chrono::microseconds;
  // 250 + 5 · 10/115200 s; 125 + 84 · 10/115200 s + 32 · 250.
  EXPECT_EQ(rplidar_delay(RplidarResponse::node, microseconds(500), 115200.0),
            microseconds(250) + Duration(434028));
  EXPECT_EQ(rplidar_delay(RplidarResponse::express, microseconds(250), 115200.0),
            microseconds(125 + 8000) + Duration(7291667));
}

}  // namespace
}  // namespace wayfare::decode
