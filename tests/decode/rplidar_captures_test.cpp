#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <sstream>

#include <wayfare/decode/rplidar_decoder.hpp>

#include "captures.hpp"
#include "makers_nodes.hpp"
#include "rplidar_streams.hpp"

namespace wayfare::decode {
namespace {

constexpr const char* kLegacy = "devices/rplidar/legacy_scan_bin";

std::vector<std::string> captures_in(const std::string& folder) {
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  return paths;
}

TEST(RplidarCaptures, EveryNodeOfTheMakersDriver) {
  WAYFARE_NEEDS_RECORDING(folder, kLegacy);
  const auto paths = captures_in(folder);
  EXPECT_EQ(paths.size(), 60U);
  const Stream scan_begins = descriptor(RplidarResponse::node, 5, true);
  std::size_t nodes = 0;
  for (const std::string& path : paths) {
    const Stream bytes = testing::file_bytes(path);
    const auto at = std::search(bytes.begin(), bytes.end(), scan_begins.begin(), scan_begins.end());
    Points expected;
    makers_nodes(
        Bytes(bytes).subspan(static_cast<std::size_t>(at - bytes.begin()) + scan_begins.size()),
        [&](const RplidarPoint& p) { expected.push_back(p); });
    const Points points = points_of(bytes);
    EXPECT_TRUE(points == expected) << path << ": " << points.size() << ", " << expected.size();
    nodes += points.size();
  }
  EXPECT_EQ(nodes, 121399U);
}

TEST(RplidarCaptures, StopsAndRestartsAreDecoded) {
  WAYFARE_NEEDS_RECORDING(folder, kLegacy);
  const auto paths = captures_in(folder);
  // Concatenated to one stream that begins inside a scan: every file begins with the rest of an
  // earlier scan, a stop, and the responses to two requests.
  Stream all;
  for (const std::string& path : paths) append(all, testing::file_bytes(path));
  RplidarDecoder decoder{RplidarFraming(RplidarResponse::node)};
  std::size_t healthy = 0, scans = 0, nodes = 0;
  const auto sink = [&](const RplidarPacket& p) {
    if (p.is_descriptor()) {
      scans += p.response() == RplidarResponse::node ? 1 : 0;
    } else if (p.response() == RplidarResponse::health) {
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

// In three files the first node after the descriptor is composed of the rest of an old one and has
// the mark of a start at 186, 194 and 230 degrees: what follows is no whole revolution.
TEST(RplidarCaptures, AWholeRevolutionIsOneTurn) {
  WAYFARE_NEEDS_RECORDING(folder, kLegacy);
  std::size_t whole = 0, marks = 0, elsewhere = 0;
  const auto revolutions = std::make_unique<RplidarRevolutions<>>();
  const auto sink = [&](const RplidarRevolution& revolution) {
    if (!revolution.whole) return;
    ++whole;
    const double first = revolution.points.front().point.angle_deg() - 360.0;
    EXPECT_NEAR(first, -5.0, 5.0);
    EXPECT_NEAR(revolution.points.back().point.angle_deg(), first + 360.0, 10.0);
  };
  for (const std::string& path : captures_in(folder)) {
    for (const RplidarPoint& p : points_of(testing::file_bytes(path))) {
      marks += p.start_of_revolution ? 1 : 0;
      elsewhere += p.start_of_revolution && !rplidar_begins_revolution(p) ? 1 : 0;
      revolutions->add({&p, 1}, LogTime{}, Duration(0), sink);
    }
    revolutions->finish(sink);
  }
  EXPECT_EQ(marks, 427U);
  EXPECT_EQ(elsewhere, 3U);
  EXPECT_GT(whole, 300U);
}

std::vector<std::array<unsigned, 4>> expected_rows(const std::string& path) {
  std::istringstream table(testing::file_text(path));
  std::vector<std::array<unsigned, 4>> rows;
  std::array<unsigned, 4> row{};
  while (table >> row[0] >> row[1] >> row[2] >> row[3]) rows.push_back(row);
  return rows;
}

void expect_makers_points(const char* name, RplidarResponse response) {
  const std::string base = "devices/rplidar/pyrplidar_capsule" + std::string(name);
  WAYFARE_NEEDS_RECORDING(path, base + ".bin");
  WAYFARE_NEEDS_RECORDING(expected_path, base + "_expected.txt");
  const auto expected = expected_rows(expected_path);
  const Points points = points_of(testing::file_bytes(path), response);
  ASSERT_EQ(points.size(), expected.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const RplidarPoint& p = points[i];
    const std::array<unsigned, 4> row = {p.angle_z_q14(), p.distance_q2, unsigned{p.quality} << 2,
                                         p.start_of_revolution ? 1U : 2U};
    EXPECT_EQ(row, expected[i]) << i;
  }
}

TEST(RplidarCaptures, ExpressBitExact) {
  expect_makers_points("82_legacy", RplidarResponse::express);
}
TEST(RplidarCaptures, UltraBitExact) { expect_makers_points("84_ultra", RplidarResponse::ultra); }

}  // namespace
}  // namespace wayfare::decode
