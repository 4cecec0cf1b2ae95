#include <wayfare/decode/rplidar_decoder.hpp>

#include <filesystem>
#include <memory>
#include <sstream>

#include <wayfare/decode/rplidar_points.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/testing/decoder_laws.hpp>
#include "decode/captures.hpp"

namespace wayfare::decode {
namespace {

using Stream = std::vector<std::uint8_t>;
using Points = std::vector<RplidarPoint>;

std::string hex(Bytes bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += "0123456789ABCDEF"[byte >> 4];
    text += "0123456789ABCDEF"[byte & 15];
  }
  return text;
}

std::string text_of(const RplidarPacket& p) {
  return std::to_string(static_cast<int>(p.answer())) + (p.is_descriptor() ? "d" : "") +
         hex(p.bytes());
}

Stream descriptor(RplidarAnswer answer, std::uint32_t length, bool stream) {
  Stream out = {0xA5, 0x5A, 0, 0, 0, 0, static_cast<std::uint8_t>(answer)};
  store_le(length | (stream ? 1U << 30 : 0U), &out[2]);
  return out;
}

Stream node(int angle_q6, int distance_q2, int quality = 15, bool start = false) {
  return {static_cast<std::uint8_t>(quality << 2 | (start ? 1 : 2)),
          static_cast<std::uint8_t>((angle_q6 & 0x7F) << 1 | 1),
          static_cast<std::uint8_t>(angle_q6 >> 7), static_cast<std::uint8_t>(distance_q2),
          static_cast<std::uint8_t>(distance_q2 >> 8)};
}

/// Head and checksum around a capsule's contents.
Stream capsule(int start_q6, const Stream& contents, bool first = false) {
  Stream out = {0, 0, static_cast<std::uint8_t>(start_q6),
                static_cast<std::uint8_t>(start_q6 >> 8 | (first ? 0x80 : 0))};
  out.insert(out.end(), contents.begin(), contents.end());
  unsigned sum = 0;
  for (const std::uint8_t byte : out) sum ^= byte;
  out[0] = static_cast<std::uint8_t>(0xA0 | (sum & 0xF));
  out[1] = static_cast<std::uint8_t>(0x50 | sum >> 4);
  return out;
}

void append(Stream& to, const Stream& more) { to.insert(to.end(), more.begin(), more.end()); }

Points points_of(const Stream& stream, RplidarAnswer inside = RplidarAnswer::none) {
  RplidarDecoder decoder{RplidarFraming(inside)};
  RplidarUnpacker unpacker;
  Points points;
  const auto sink = [&](const RplidarPacket& packet) {
    unpacker.add(packet, [&](std::span<const RplidarPoint> some) {
      points.insert(points.end(), some.begin(), some.end());
    });
  };
  decoder.feed(stream, sink);
  decoder.finish(sink);
  return points;
}

TEST(Rplidar, RequestsAsTheManualSpellsThem) {
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
  EXPECT_EQ(hex(rplidar_get_conf(0x70).bytes()),
            "A5840470000000"
            "55");
  EXPECT_EQ(hex(rplidar_get_conf(0x7F, 2).bytes()),
            "A584067F0000000200"
            "5A");
}

TEST(Rplidar, SingleAnswers) {
  Stream bytes = descriptor(RplidarAnswer::info, 20, false);
  append(bytes, {0x18, 29, 1, 7, 0xAA, 0xBB, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xCC});
  append(bytes, descriptor(RplidarAnswer::health, 3, false));
  append(bytes, {1, 0x34, 0x12});
  append(bytes, descriptor(RplidarAnswer::sample_rate, 4, false));
  append(bytes, {0xFC, 0x01, 0xFE, 0x00});
  append(bytes, descriptor(RplidarAnswer::conf, 5, false));
  append(bytes, {0x75, 0, 0, 0, 0x84});
  RplidarDecoder decoder;
  int seen = 0;
  const auto sink = [&](const RplidarPacket& p) {
    if (p.is_descriptor()) return;
    ++seen;
    if (p.answer() == RplidarAnswer::info) {
      const auto info = rplidar_info(p.bytes());
      ASSERT_TRUE(info);
      EXPECT_EQ(info->model, 0x18);
      EXPECT_EQ(info->firmware_major, 1);
      EXPECT_EQ(info->firmware_minor, 29);
      EXPECT_EQ(info->hardware, 7);
      EXPECT_EQ(info->serial[15], 0xCC);
    } else if (p.answer() == RplidarAnswer::health) {
      const auto health = rplidar_health(p.bytes());
      ASSERT_TRUE(health);
      EXPECT_EQ(health->status, RplidarHealth::Status::warning);
      EXPECT_EQ(health->code, 0x1234);
    } else if (p.answer() == RplidarAnswer::sample_rate) {
      const auto rate = rplidar_sample_rate(p.bytes());
      ASSERT_TRUE(rate);
      EXPECT_EQ(rate->standard_us, 508);
      EXPECT_EQ(rate->express_us, 254);
    } else {
      const auto conf = rplidar_conf(p.bytes());
      ASSERT_TRUE(conf);
      EXPECT_EQ(conf->key, 0x75U);
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
  Stream bytes = descriptor(RplidarAnswer::node, 5, true);
  append(bytes, node(64, 4000, 47, true));
  append(bytes, node(128, 0, 0));
  EXPECT_EQ(points_of(bytes), (Points{{64, 4000, 47, true}, {128, 0, 0, false}}));
  EXPECT_EQ(points_of(bytes)[0].distance_m(), 1.0);
  EXPECT_EQ(points_of(bytes)[0].angle_deg(), 1.0);
}

TEST(Rplidar, ARestartInsideANode) {
  for (std::size_t cut = 0; cut <= 5; ++cut) {
    Stream bytes = descriptor(RplidarAnswer::node, 5, true);
    for (int i = 0; i < 20; ++i) append(bytes, node(64 * i, 4000 + i));
    const Stream old = node(64 * 20, 4020);
    bytes.insert(bytes.end(), old.begin(), old.begin() + static_cast<long>(cut));
    append(bytes, {0xA5, 0x25, 0xFF, 0xFF, 0xA5, 0x52, 0xA5, 0x20});
    append(bytes, descriptor(RplidarAnswer::health, 3, false));
    append(bytes, {0, 0, 0});
    append(bytes, descriptor(RplidarAnswer::node, 5, true));
    for (int i = 0; i < 20; ++i) append(bytes, node(6400 + 64 * i, 8000 + i));
    const Points points = points_of(bytes);
    ASSERT_GE(points.size(), 40U) << cut;
    // Before it there may be one node made of the rest of the last and the echoes.
    EXPECT_LE(points.size(), 42U) << cut;
    for (std::size_t i = 0; i < 20; ++i) {
      EXPECT_EQ(points[i].distance_q2, 4000 + i);
      EXPECT_EQ(points[points.size() - 20 + i].distance_q2, 8000 + i);
    }
  }
}

TEST(Rplidar, NodesAreFoundAgainAfterALostByte) {
  for (std::size_t lost = 1; lost < 9; ++lost) {
    Stream bytes = descriptor(RplidarAnswer::node, 5, true);
    for (int i = 0; i < 60; ++i) append(bytes, node(64 * i, 4001 + i));
    const auto at = bytes.begin() + 7 + 5 * 30 + 2;
    bytes.erase(at, at + static_cast<long>(lost));
    const Points points = points_of(bytes);
    // All that is whole is there.
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

// Encoded here from known points; what the makers' arithmetic gives for them is said in the
// comments.
TEST(Rplidar, ExpressCapsule) {
  Stream contents, empty(80);
  for (int i = 0; i < 16; ++i) {
    const int d1 = (1000 + i) << 2 | 1, d2 = 0;  // millimetres; top two bits of the first offset
    append(contents, {static_cast<std::uint8_t>(d1), static_cast<std::uint8_t>(d1 >> 8),
                      static_cast<std::uint8_t>(d2), static_cast<std::uint8_t>(d2 >> 8), 0x30});
  }
  Stream bytes = descriptor(RplidarAnswer::express, 84, true);
  append(bytes, capsule(350 * 64, contents, true));
  append(bytes, capsule(22 * 64, empty));
  const Points points = points_of(bytes);
  ASSERT_EQ(points.size(), 32U);
  // 32° in 32 steps; the first of a pair stands 16/8 = 2° before its place, the second 3/8°.
  EXPECT_EQ(points[0], (RplidarPoint{348 * 64, 4000, 47, false}));
  EXPECT_EQ(points[1], (RplidarPoint{351 * 64 - 24, 0, 0, false}));
  EXPECT_EQ(points[10], (RplidarPoint{358 * 64, 4020, 47, false}));
  // The turn ends where the place without offset reaches 360°: with the tenth.
  for (std::size_t i = 0; i < 32; ++i) EXPECT_EQ(points[i].start_of_turn, i == 9) << i;
}

TEST(Rplidar, DenseCapsule) {
  Stream contents;
  for (int i = 0; i < 40; ++i)
    append(contents,
           {static_cast<std::uint8_t>(2000 + i), static_cast<std::uint8_t>((2000 + i) >> 8)});
  Stream bytes = descriptor(RplidarAnswer::dense, 84, true);
  append(bytes, capsule(10 * 64, contents, true));
  append(bytes, capsule(30 * 64, contents));
  append(bytes, capsule(50 * 64, contents));
  const Points points = points_of(bytes);
  ASSERT_EQ(points.size(), 80U);
  for (std::size_t i = 0; i < 40; ++i)  // half a degree apart
    EXPECT_EQ(points[i], (RplidarPoint{static_cast<std::uint16_t>(640 + 32 * i),
                                       static_cast<std::uint32_t>(8000 + 4 * i), 47, false}));
}

TEST(Rplidar, ADamagedCapsuleCostsItsNeighboursPointsOnly) {
  Stream bytes = descriptor(RplidarAnswer::dense, 84, true);
  for (int i = 0; i < 6; ++i) append(bytes, capsule(640 * (i + 1), Stream(80, 1), i == 0));
  EXPECT_EQ(points_of(bytes).size(), 200U);
  Stream flipped = bytes;
  flipped[7 + 84 * 2 + 50] ^= 4;
  EXPECT_EQ(points_of(flipped).size(), 120U);  // 0 and 1 make points of 0, 3 to 5 of 3 and 4
  Stream restarted = bytes;
  restarted[7 + 84 * 3 + 3] |= 0x80;  // the encoder began anew
  restarted[7 + 84 * 3 + 1] ^= 0x08;
  EXPECT_EQ(points_of(restarted).size(), 160U);
}

TEST(Rplidar, TurnsAndScans) {
  std::vector<std::pair<std::size_t, bool>> turns;
  RplidarTurns<100> assembler;
  LaserScan scan;
  const auto sink = [&](const RplidarTurn& turn) {
    turns.emplace_back(turn.points.size(), turn.whole);
    if (turns.size() == 2) {
      EXPECT_EQ(turn.points[1].time - turn.points[0].time, std::chrono::microseconds(500));
      scan = to_laser_scan(turn, {36, 0.15F, 12.0F});
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
  EXPECT_EQ(turns, (std::vector<std::pair<std::size_t, bool>>{
                       {31, false}, {36, true}, {36, true}, {7, false}}));
  // 90° clockwise of the front is 90° to the right: bearing −π/2, a quarter from the back.
  EXPECT_NEAR(scan.ranges_m[9], 1.09F, 1e-6F);
  EXPECT_NEAR(scan.bearing(9).radians(), -std::numbers::pi / 2.0, 1e-12);
  EXPECT_NEAR(scan.ranges_m[0], 1.18F, 1e-6F);   // behind
  EXPECT_NEAR(scan.ranges_m[18], 1.00F, 1e-6F);  // ahead
  EXPECT_EQ(scan.time, LogTime{} + sample * 31);
}

TEST(Rplidar, ATurnLongerThanItsRoomIsNotWhole) {
  RplidarTurns<10> assembler;
  std::size_t whole = 0, turns = 0;
  const auto sink = [&](const RplidarTurn& turn) {
    ++turns;
    whole += turn.whole ? 1 : 0;
    EXPECT_LE(turn.points.size(), 10U);
  };
  for (int i = 0; i < 60; ++i) {
    const RplidarPoint p{0, 0, 0, i % 20 == 0};
    assembler.add({&p, 1}, LogTime{}, Duration(1), sink);
  }
  EXPECT_EQ(turns, 2U);
  EXPECT_EQ(whole, 0U);
  EXPECT_EQ(assembler.dropped_points(), 30U);
}

TEST(Rplidar, Delays) {
  using std::chrono::microseconds;
  // 250 + 5 · 10/115200 s; 125 + 84 · 10/115200 s + 32 · 250.
  EXPECT_EQ(rplidar_delay(RplidarAnswer::node, microseconds(500), 115200.0),
            microseconds(250) + Duration(434028));
  EXPECT_EQ(rplidar_delay(RplidarAnswer::express, microseconds(250), 115200.0),
            microseconds(125 + 8000) + Duration(7291667));
}

// ---- captures ----

/// The makers' state machine for nodes: bits are looked at byte by byte, nothing else is.
Points drivers_nodes(Bytes bytes) {
  Points points;
  std::array<std::uint8_t, 5> held{};
  std::size_t n = 0;
  for (const std::uint8_t byte : bytes) {
    if (n == 0 && ((byte >> 1 ^ byte) & 1) == 0) continue;
    if (n == 1 && (byte & 1) == 0) {
      n = 0;
      continue;
    }
    held[n++] = byte;
    if (n < 5) continue;
    points.push_back({static_cast<std::uint16_t>((held[1] | held[2] << 8) >> 1),
                      static_cast<std::uint32_t>(held[3] | held[4] << 8),
                      static_cast<std::uint8_t>(held[0] >> 2), (held[0] & 1) != 0});
    n = 0;
  }
  return points;
}

std::vector<std::string> legacy_captures() {
  std::vector<std::string> paths;
  const std::string folder = testing::recording("devices/rplidar/legacy_scan_bin");
  if (folder.empty()) return paths;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  return paths;
}

TEST(RplidarCaptures, EveryNodeADriverWouldGive) {
  const auto paths = legacy_captures();
  if (paths.empty()) GTEST_SKIP() << "needs devices/rplidar/legacy_scan_bin in WAYFARE_DATA_DIR";
  EXPECT_EQ(paths.size(), 60U);
  const Stream scan_begins = descriptor(RplidarAnswer::node, 5, true);
  std::size_t nodes = 0;
  for (const std::string& path : paths) {
    const Stream bytes = testing::file_bytes(path);
    const auto at = std::search(bytes.begin(), bytes.end(), scan_begins.begin(), scan_begins.end());
    const Points expected = drivers_nodes(
        Bytes(bytes).subspan(static_cast<std::size_t>(at - bytes.begin()) + scan_begins.size()));
    const Points points = points_of(bytes);
    EXPECT_TRUE(points == expected) << path << ": " << points.size() << ", " << expected.size();
    nodes += points.size();
  }
  EXPECT_EQ(nodes, 121399U);
}

TEST(RplidarCaptures, StopsAndRestartsAreFollowed) {
  const auto paths = legacy_captures();
  if (paths.empty()) GTEST_SKIP() << "needs devices/rplidar/legacy_scan_bin in WAYFARE_DATA_DIR";
  // Played one after the other as one stream that begins inside a scan: every file begins with the
  // rest of an old one, a stop, and the answers to two requests.
  Stream all;
  for (const std::string& path : paths) append(all, testing::file_bytes(path));
  RplidarDecoder decoder{RplidarFraming(RplidarAnswer::node)};
  std::size_t healthy = 0, scans = 0, nodes = 0;
  const auto sink = [&](const RplidarPacket& p) {
    if (p.is_descriptor()) {
      scans += p.answer() == RplidarAnswer::node ? 1 : 0;
    } else if (p.answer() == RplidarAnswer::health) {
      const auto health = rplidar_health(p.bytes());
      healthy += health && health->status == RplidarHealth::Status::good ? 1 : 0;
    } else {
      ++nodes;
    }
  };
  decoder.feed(all, sink);
  decoder.finish(sink);
  EXPECT_EQ(scans, 60U);
  EXPECT_EQ(healthy, 60U);
  EXPECT_GE(nodes, 121399U);
}

std::vector<std::array<unsigned, 4>> expected_rows(const std::string& path) {
  std::istringstream table(testing::file_text(path));
  std::vector<std::array<unsigned, 4>> rows;
  std::array<unsigned, 4> row{};
  while (table >> row[0] >> row[1] >> row[2] >> row[3]) rows.push_back(row);
  return rows;
}

void expect_makers_points(const char* name, RplidarAnswer answer) {
  const std::string base = "devices/rplidar/pyrplidar_capsule" + std::string(name);
  WAYFARE_NEEDS_RECORDING(path, base + ".bin");
  WAYFARE_NEEDS_RECORDING(expected_path, base + "_expected.txt");
  const auto expected = expected_rows(expected_path);
  const Points points = points_of(testing::file_bytes(path), answer);
  ASSERT_EQ(points.size(), expected.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const RplidarPoint& p = points[i];
    const std::array<unsigned, 4> row = {p.angle_z_q14(), p.distance_q2, unsigned{p.quality} << 2,
                                         p.start_of_turn ? 1U : 2U};
    EXPECT_EQ(row, expected[i]) << i;
  }
}

TEST(RplidarCaptures, ExpressBitExact) {
  expect_makers_points("82_legacy", RplidarAnswer::express);
}
TEST(RplidarCaptures, UltraBitExact) { expect_makers_points("84_ultra", RplidarAnswer::ultra); }

// ---- laws ----

testing::DecoderLaws<RplidarDecoder> laws_of(const Stream& stream, RplidarAnswer inside) {
  testing::DecoderLaws<RplidarDecoder> laws{stream, text_of};
  laws.make = [inside] { return std::make_unique<RplidarDecoder>(RplidarFraming(inside)); };
  laws.work_per_byte = 2.0 * RplidarFraming::kCapacity;
  return laws;
}

Stream random_capsules(RplidarAnswer answer, int count) {
  Rng rng(5);
  Stream stream;
  for (int i = 0; i < count; ++i) {
    Stream contents(answer == RplidarAnswer::ultra ? 128 : 80);
    for (auto& byte : contents) byte = static_cast<std::uint8_t>(rng());
    append(stream, capsule(i * 700 % (360 * 64), contents, i == 0));
  }
  return stream;
}

TEST(RplidarLaws, Capsules) {
  for (const auto answer : {RplidarAnswer::express, RplidarAnswer::ultra, RplidarAnswer::dense}) {
    const auto laws = laws_of(random_capsules(answer, 20), answer);
    laws.check();
    const testing::DamageReport report = laws.damage(10000);
    report.record("capsules_" + std::to_string(static_cast<int>(answer)));
    EXPECT_EQ(report.lost, 0U);
    // Eight bits of XOR, so one damaged capsule in 256 passes, and may hide its neighbour.
    EXPECT_LE(static_cast<double>(report.false_frames), report.most_false(256.0));
    EXPECT_LE(report.hidden, 2 * report.false_frames);
    EXPECT_GT(report.undamaged, 100'000U);
  }
}

TEST(RplidarLaws, SingleAnswers) {
  Stream stream;
  for (int i = 0; i < 10; ++i) {
    append(stream, descriptor(RplidarAnswer::health, 3, false));
    append(stream, {0, 0, 0});
  }
  laws_of(stream, RplidarAnswer::none).any_split_gives_the_same();
  laws_of(stream, RplidarAnswer::none).work_is_bounded();
}

TEST(RplidarLaws, Nodes) {
  const auto paths = legacy_captures();
  if (paths.empty()) GTEST_SKIP() << "needs devices/rplidar/legacy_scan_bin in WAYFARE_DATA_DIR";
  const Stream bytes = testing::file_bytes(paths[0]);
  const Stream scan_begins = descriptor(RplidarAnswer::node, 5, true);
  const auto at = std::search(bytes.begin(), bytes.end(), scan_begins.begin(), scan_begins.end());
  const Stream nodes(at + 7, at + 7 + 5 * 200);
  const auto laws = laws_of(nodes, RplidarAnswer::node);
  laws.any_split_gives_the_same();
  laws.work_is_bounded();
  const testing::DamageReport report = laws.damage(10000);
  report.record("nodes");
  // Three check bits and no checksum: damage gives at most one node that is none, and in one case
  // of fifty hides a neighbour or leaves it without others to be believed by.
  EXPECT_LE(report.false_frames, report.edits);
  EXPECT_LE(report.lost + report.hidden, report.edits / 50);
  EXPECT_GT(report.undamaged, 1'900'000U);
}

}  // namespace
}  // namespace wayfare::decode
