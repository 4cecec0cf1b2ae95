#include <wayfare/decode/rplidar_decoder.hpp>

#include <chrono>
#include <cmath>
#include <memory>
#include <tuple>

#include <wayfare/decode/rplidar_conf.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/decode/rplidar_stream.hpp>
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
  EXPECT_EQ(hex(rplidar_express_scan(3).bytes()),  // A5 ^ 82 ^ 05 ^ 03 = 21
            "A582050300000000"
            "21");
  EXPECT_EQ(hex(rplidar_get_board_flags().bytes()), "A5FF04000000005E");  // A5 ^ FF ^ 04
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

RplidarPoint point_at(int deg, std::uint32_t distance_q2, std::uint8_t quality = 10) {
  return {static_cast<std::uint16_t>(64 * deg), distance_q2, quality, false};
}

// 150 mm are the least range and still one, 12 m are too far. Beams of 10° from −180° on, those of
// a sweep from −350° to 0: ahead is beam 18 and 35, 90° to the right 9 and 26, behind 0 and 17.
TEST(Rplidar, ABeamHasItsNearestPointWithinTheLimits) {
  std::vector<TimedRplidarPoint> points;
  for (const RplidarPoint& p :
       {point_at(0, 8000, 20), point_at(1, 4000, 30), point_at(2, 6000, 40), point_at(90, 599),
        point_at(91, 600, 50), point_at(180, 48'000), point_at(181, 47'999, 60)})
    points.push_back({p, LogTime{}});
  const RplidarScanOptions options{36, 0.15F, 12.0F};
  const LaserScan scan = to_laser_scan({points, true}, options);
  std::vector<float> qualities = {1.0F};
  const LaserScan sweep = to_laser_sweep({points, true}, options, &qualities);
  ASSERT_EQ(scan.ranges_m.size(), 36U);
  ASSERT_EQ(sweep.ranges_m.size(), 36U);
  ASSERT_EQ(qualities.size(), 36U);
  std::size_t returned = 0;
  for (std::size_t i = 0; i < 36; ++i) {
    if (!std::isnan(scan.ranges_m[i])) ++returned;
    const float expected = i == 35 ? 30.0F : i == 26 ? 50.0F : i == 17 ? 60.0F : 0.0F;
    EXPECT_EQ(qualities[i], expected) << i;
    EXPECT_EQ(std::isnan(sweep.ranges_m[i]), expected == 0.0F) << i;
  }
  EXPECT_EQ(returned, 3U);
  for (const auto& [ahead, right, behind, ranges] :
       {std::tuple(18, 9, 0, &scan.ranges_m), std::tuple(35, 26, 17, &sweep.ranges_m)}) {
    EXPECT_EQ((*ranges)[static_cast<std::size_t>(ahead)], 1.0F);
    EXPECT_EQ((*ranges)[static_cast<std::size_t>(right)], 0.15F);
    EXPECT_NEAR((*ranges)[static_cast<std::size_t>(behind)], 11.99975F, 1e-6F);
  }
  EXPECT_EQ(scan.min_range_m, 0.15F);
  EXPECT_EQ(sweep.max_range_m, 12.0F);
}

TEST(Rplidar, AStartIsWithin45DegreesOfAhead) {
  for (const auto& [deg, begins] :
       {std::pair{0, true}, {45, true}, {46, false}, {180, false}, {314, false}, {315, true}}) {
    RplidarPoint point = point_at(deg, 4000);
    EXPECT_FALSE(rplidar_begins_revolution(point)) << deg;
    point.start_of_revolution = true;
    EXPECT_EQ(rplidar_begins_revolution(point), begins) << deg;
  }
}

TEST(Rplidar, NodesFollowWithinTenDegrees) {
  constexpr int kTurn = 360 * 64;
  for (const auto& [angle, last, follows] :
       {std::tuple(639, 0, true), std::tuple(640, 0, false), std::tuple(0, 639, true),
        std::tuple(0, 640, false), std::tuple(10, kTurn - 629, true),
        std::tuple(10, kTurn - 630, false), std::tuple(kTurn - 629, 10, true),
        std::tuple(kTurn - 630, 10, false), std::tuple(kTurn / 2, 0, false)})
    EXPECT_EQ(rplidar_follows(angle, last), follows) << angle << " after " << last;
}

// A turn is less than 360°: the last angle of a node is 360° − 1/64°. A start bit and its inverse
// differ, and the check bit is set.
TEST(Rplidar, NodesByTheirBits) {
  const Stream good = node(360 * 64 - 1, 4000);
  EXPECT_TRUE(is_rplidar_node(good.data()));
  EXPECT_EQ(rplidar_node_angle(good.data()), 360 * 64 - 1);
  EXPECT_FALSE(is_rplidar_node(node(360 * 64, 4000).data()));
  for (const auto& [byte, bit] : {std::pair{0U, 1}, {0U, 2}, {1U, 1}}) {
    Stream wrong = good;
    wrong[byte] = static_cast<std::uint8_t>(wrong[byte] ^ bit);
    EXPECT_FALSE(is_rplidar_node(wrong.data())) << byte << ", " << bit;
  }
}

// Two sync nibbles, the XOR of the rest, and a next start angle by less than 90° ahead.
TEST(Rplidar, CapsulesFollowWithinAQuarter) {
  const auto run = [](int first_q6, int next_q6) {
    Stream bytes = capsule(first_q6, Stream(80, 1));
    append(bytes, capsule(next_q6, Stream(80, 1)));
    return is_rplidar_capsule_run(bytes, RplidarResponse::dense);
  };
  constexpr int kTurn = 360 * 64, kQuarter = 90 * 64;
  for (const auto& [first, next, follows] :
       {std::tuple(0, 1, true), std::tuple(0, 0, false), std::tuple(1, 0, false),
        std::tuple(0, kQuarter - 1, true), std::tuple(0, kQuarter, false),
        std::tuple(kTurn - 1, 0, true), std::tuple(kTurn, kTurn + 1, false),
        std::tuple(kTurn - 1, kTurn, false)})
    EXPECT_EQ(run(first, next), follows) << first << ", " << next;
  const Stream whole = capsule(640, Stream(80, 1));
  EXPECT_TRUE(is_rplidar_capsule(whole));
  for (const auto& [byte, bit] :
       {std::pair{0U, 0x10}, {0U, 0x01}, {1U, 0x10}, {1U, 0x01}, {2U, 0x01}, {83U, 0x80}}) {
    Stream wrong = whole;
    wrong[byte] = static_cast<std::uint8_t>(wrong[byte] ^ bit);
    EXPECT_FALSE(is_rplidar_capsule(wrong)) << byte << ", " << bit;
  }
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
  // At 10⁶ baud and 100 µs for a sample: 50 µs, 10 µs for each byte, and the samples of the next
  // capsule except where the points are decoded at once.
  struct Case {
    RplidarResponse response;
    int bytes, points, later;
  };
  using enum RplidarResponse;
  for (const Case& c : {Case{node, 5, 1, 0},
                        {express, 84, 32, 32},
                        {dense, 84, 40, 40},
                        {ultra, 132, 96, 96},
                        {ultra_dense, 170, 64, 64},
                        {hq, 781, 96, 0},
                        {info, 0, 0, 0}}) {
    const auto number = static_cast<int>(c.response);
    EXPECT_EQ(rplidar_delay(c.response, microseconds(100), 1e6),
              microseconds(50 + 10 * c.bytes + 100 * c.later))
        << number;
    EXPECT_EQ(rplidar_packet_points(c.response), c.points) << number;
    EXPECT_EQ(rplidar_packet_bytes(c.response), static_cast<std::size_t>(c.bytes)) << number;
  }
}

// At 115200 baud a byte takes 10/115200 s. A node was measured half a sample and the time of its
// own five bytes before its last byte arrived; the nodes behind it in the same chunk came later. A
// sample is an A1's 500 µs until the device tells another.
TEST(Rplidar, PointsHaveTheTimesOfTheirBytes) {
  EXPECT_EQ(line_time(1152, 115200), std::chrono::milliseconds(100));
  struct Case {
    RplidarResponse response;
    Stream told;
    double sample_s;
  };
  const Case cases[] = {
      {RplidarResponse::sample_rate, {0xFC, 1, 0xFE, 0}, 508e-6},        // 508, 254 µs
      {RplidarResponse::sample_rate, {0xFC, 1, 0, 0}, 500e-6},           // no time
      {RplidarResponse::sample_rate, {0, 0, 0xFE, 0}, 500e-6},           // no time
      {RplidarResponse::conf, {0x71, 0, 0, 0, 0, 0x2C, 1, 0}, 300e-6},   // 300 · 256
      {RplidarResponse::conf, {0x74, 0, 0, 0, 0, 0x2C, 1, 0}, 500e-6}};  // a distance
  constexpr int kNodes = 72;
  for (const Case& c : cases) {
    Stream bytes = descriptor(c.response, static_cast<std::uint32_t>(c.told.size()), false);
    append(bytes, c.told);
    append(bytes, descriptor(RplidarResponse::node, 5, true));
    for (int i = 0; i < 3 * kNodes + 2; ++i)
      append(bytes, node(320 * (i % kNodes), 4000, 15, i % kNodes == 0));
    const LogTime arrived = LogTime::from_seconds(1e9);
    std::vector<Duration> before;
    const auto stream = std::make_unique<RplidarStream>(115200);
    stream->feed(bytes, arrived, [&](const RplidarRevolution& r) {
      before.push_back(arrived - r.points.front().time);
    });
    ASSERT_EQ(before.size(), 3U);
    for (std::size_t k = 0; k < 3; ++k) {
      // The rest of its turn, the turns after it and two nodes.
      const double bytes_behind = 5.0 * (kNodes * (3.0 - static_cast<double>(k)) + 1.0);
      EXPECT_NEAR(to_seconds(before[k]), c.sample_s / 2 + (bytes_behind + 5.0) * 10.0 / 115200.0,
                  1e-8)
          << k;
    }
  }
}

}  // namespace
}  // namespace wayfare::decode
