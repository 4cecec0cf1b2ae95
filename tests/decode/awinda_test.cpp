#include <wayfare/decode/awinda.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <sstream>

#include <wayfare/core/random.hpp>
#include <wayfare/decode/xbus.hpp>
#include "captures.hpp"

namespace wayfare::decode {
namespace {

using Stream = std::vector<std::uint8_t>;

AwindaSnapshot snapshot(std::uint32_t frame, bool retransmitted = false) {
  AwindaSnapshot s;
  s.device = 7;
  s.frame = frame;
  s.retransmitted = retransmitted;
  return s;
}

template <class Order>
std::vector<std::uint32_t> ordered(Order& order, const std::vector<std::uint32_t>& frames) {
  std::vector<std::uint32_t> seen;
  const auto sink = [&](const AwindaSnapshot& s) { seen.push_back(s.frame); };
  for (const std::uint32_t frame : frames) order.add(snapshot(frame), sink);
  order.finish(sink);
  return seen;
}

using Frames = std::vector<std::uint32_t>;

TEST(AwindaReorderBuffer, RetransmissionsAreSorted) {
  AwindaReorderBuffer<8> order;
  EXPECT_EQ(ordered(order, {1, 2, 4, 5, 3, 6}), (Frames{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(order.late() + order.missing(), 0U);
}

TEST(AwindaReorderBuffer, AcrossTheEndOfTheCounter) {
  AwindaReorderBuffer<8> order;
  EXPECT_EQ(ordered(order, {0xFFFFFFFE, 0, 0xFFFFFFFF, 1}), (Frames{0xFFFFFFFE, 0xFFFFFFFF, 0, 1}));
}

TEST(AwindaReorderBuffer, WaitsForOneWindow) {
  AwindaReorderBuffer<4> order;
  std::vector<std::uint32_t> seen;
  const auto sink = [&](const AwindaSnapshot& s) { seen.push_back(s.frame); };
  for (const std::uint32_t frame : {10U, 12U, 13U, 14U}) order.add(snapshot(frame), sink);
  EXPECT_EQ(seen, Frames{10});
  order.add(snapshot(15), sink);  // 11 is four frames late
  EXPECT_EQ(seen, (Frames{10, 12, 13, 14, 15}));
  EXPECT_EQ(order.missing(), 1U);
  order.add(snapshot(11, true), sink);
  EXPECT_EQ(order.late(), 1U);
  order.add(snapshot(17), sink);
  order.add(snapshot(17), sink);
  EXPECT_EQ(order.late(), 2U);
  order.finish(sink);
  EXPECT_EQ(seen, (Frames{10, 12, 13, 14, 15, 17}));
}

TEST(AwindaReorderBuffer, AJumpRestarts) {
  AwindaReorderBuffer<8> order;
  EXPECT_EQ(ordered(order, {5, 7, 1'000'000, 1'000'001}), (Frames{5, 7, 1'000'000, 1'000'001}));
}

// After frame 1 or 100 the next is 2 or 101: 15 ahead, 2 to 9 fall out of the window, which begins
// at 10; 16 ahead or back is another sequence, but a retransmission is late.
TEST(AwindaReorderBuffer, AJumpByTwiceTheWindowRestarts) {
  struct Case {
    Frames arriving, seen;
    std::uint64_t missing, late;
  };
  for (const Case& c : {Case{{1, 17}, {1, 17}, 8, 0},
                        {{1, 18}, {1, 18}, 0, 0},
                        {{100, 86}, {100}, 0, 1},
                        {{100, 85}, {100, 85}, 0, 0}}) {
    AwindaReorderBuffer<8> order;
    EXPECT_EQ(ordered(order, c.arriving), c.seen);
    EXPECT_EQ(order.missing(), c.missing) << c.arriving[1];
    EXPECT_EQ(order.late(), c.late) << c.arriving[1];
  }
  AwindaReorderBuffer<8> order;
  Frames seen;
  const auto sink = [&](const AwindaSnapshot& s) { seen.push_back(s.frame); };
  order.add(snapshot(100), sink);
  order.add(snapshot(85, true), sink);
  EXPECT_EQ(seen, Frames{100});
  EXPECT_EQ(order.late(), 1U);
}

// No shuffle within the window loses a snapshot.
TEST(AwindaReorderBuffer, AnyShuffleWithinTheWindow) {
  Rng rng(8);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> arrivals;
    for (std::uint32_t f = 0; f < 300; ++f)
      arrivals.emplace_back(f == 0 ? 0 : f + rng.below(13), 0xFFFFFF80U + f);
    std::stable_sort(arrivals.begin(), arrivals.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    Frames frames, expected;
    for (const auto& [when, frame] : arrivals) frames.push_back(frame);
    if (frames[0] != 0xFFFFFF80U) continue;  // the first must come first
    for (std::uint32_t f = 0; f < 300; ++f) expected.push_back(0xFFFFFF80U + f);
    AwindaReorderBuffer<16> order;
    ASSERT_EQ(ordered(order, frames), expected);
  }
}

TEST(Awinda, MotionAcrossALostSnapshotIsTheMeanOfItsParts) {
  // Half a revolution per second about z with specific force along x, integrated by hand.
  const auto at = [](std::uint32_t frame) {
    AwindaSnapshot s = snapshot(frame);
    const double angle = M_PI * 0.01 * frame;
    s.orientation = {0, 0, static_cast<std::int32_t>(std::lround(std::sin(angle / 2) * 0x1p31))};
    // Velocity in the first frame's axes: ∫ (cos, sin) = (sin, 1 − cos) / rate, and 2^28 wraps.
    s.velocity[0] = static_cast<std::int32_t>(std::lround(std::sin(angle) / M_PI * 65536.0));
    s.velocity[1] = static_cast<std::int32_t>(std::lround((1 - std::cos(angle)) / M_PI * 65536.0));
    s.velocity[2] = 0x7FFFFFF + static_cast<std::int32_t>(frame);  // about to wrap
    if (s.velocity[2] >= 1 << 27) s.velocity[2] -= 1 << 28;
    return s;
  };
  for (const std::uint32_t lost : {0U, 3U}) {
    const AwindaMotion m = awinda_motion(at(0), at(1 + lost), 0.01);
    EXPECT_EQ(m.frames, 1 + lost);
    EXPECT_NEAR(m.rate_radps.z(), M_PI, 1e-6);
    EXPECT_NEAR(m.acceleration_mps2.x(), 1.0, 2e-3);  // 2^-16 m/s over 10 ms
    EXPECT_NEAR(m.acceleration_mps2.y(), 0.0, 2e-3);
    EXPECT_NEAR(m.acceleration_mps2.z(), 100.0 / 65536.0, 1e-9);
  }
}

TEST(Awinda, TheStatusIdentifiesTheOmittedComponent) {
  const Eigen::Quaterniond q(0.1, 0.7, 0.5, 0.5);
  const Eigen::Quaterniond unit = q.normalized();
  const std::array<double, 4> wxyz = {unit.w(), unit.x(), unit.y(), unit.z()};
  for (unsigned out = 0; out < 4; ++out) {
    AwindaSnapshot s;
    s.status = static_cast<std::uint16_t>(out << 11);
    for (unsigned i = 0; i < 3; ++i)
      s.orientation[i] = static_cast<std::int32_t>(wxyz[(out + 1 + i) % 4] * 0x1p31);
    EXPECT_LT(s.integrated_orientation().angularDistance(unit), 1e-8);
  }
}

TEST(Awinda, SnapshotsOfTheWrongLengthAreRejected) {
  Stream data = {0xC8, 0x10, 45};
  data.resize(48);
  EXPECT_FALSE(awinda_snapshot(data));
  data[2] = 46;
  EXPECT_FALSE(awinda_snapshot(data));
  data.resize(49);
  EXPECT_TRUE(awinda_snapshot(data));
  EXPECT_FALSE(awinda_configuration(Stream(97)));
  Stream configuration(98);
  configuration[97] = 1;  // a tracker without data
  EXPECT_FALSE(awinda_configuration(configuration));
}

TEST(AwindaStation, HasALimitedNumberOfTrackers) {
  AwindaStation<2, 8> station(0.01);
  const auto sink = [](const AwindaMotion&) {};
  for (std::uint32_t device = 0; device < 5; ++device) {
    AwindaSnapshot s = snapshot(1);
    s.device = device;
    station.add(s, sink);
  }
  EXPECT_EQ(station.trackers(), 2U);
  EXPECT_EQ(station.refused(), 3U);
}

// ---- captures ----

struct Row {
  unsigned counter = 0;
  std::array<double, 9> values{};  ///< acceleration, rate, field
};

std::vector<Row> exported(const std::string& path) {
  std::vector<Row> rows;
  std::istringstream lines(testing::file_text(path));
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] < '0' || line[0] > '9') continue;
    std::istringstream fields(line);
    Row row;
    double skipped = 0.0;
    fields >> row.counter;
    for (int i = 0; i < 5; ++i) fields >> skipped;
    for (double& value : row.values) fields >> value;
    if (fields) rows.push_back(row);
  }
  return rows;
}

struct Decoded {
  std::map<std::uint32_t, std::vector<AwindaMotion>> motions;
  std::optional<std::uint32_t> station;
  double period_s = 0.0;
  std::size_t snapshots = 0, retransmitted = 0;
  std::uint64_t late = 0, missing = 0;
  DecoderStatistics statistics;
};

Decoded decode_log(const std::string& path) {
  Decoded d;
  const auto decoder = std::make_unique<XbusDecoder>();
  const auto station = std::make_unique<AwindaStation<>>(0.01);
  const auto keep = [&](const AwindaMotion& m) { d.motions[m.device].push_back(m); };
  const auto sink = [&](const XbusMessage& m) {
    if (m.id() == XbusId::configuration) {
      if (const auto c = awinda_configuration(m.data())) {
        d.station = c->station;
        d.period_s = c->period_s;
        EXPECT_EQ(c->trackers, 8);
        EXPECT_EQ(c->tracker(0), 0x10B426DBU);
      }
    }
    if (m.id() != XbusId::mt_data2) return;
    const auto s = awinda_snapshot(m.data());
    if (!s) return;
    ++d.snapshots;
    d.retransmitted += s->retransmitted ? 1 : 0;
    EXPECT_TRUE(s->rssi_dbm && *s->rssi_dbm < 0);
    station->add(*s, keep);
  };
  decoder->feed(testing::file_bytes(path), sink);
  decoder->finish(sink);
  station->finish(keep);
  d.late = station->late();
  d.missing = station->missing();
  d.statistics = decoder->statistics();
  return d;
}

void expect_export(const std::string& folder, std::size_t messages) {
  const std::string base = "devices/xsens/awinda_mtb/" + folder + "/MT_012012B9_000";
  WAYFARE_NEEDS_RECORDING(path, base + ".mtb.gz");
  const Decoded d = decode_log(path);
  EXPECT_EQ(d.statistics.frames, messages);
  EXPECT_EQ(d.statistics.skipped_bytes, 0U);
  EXPECT_EQ(d.station, 0x012012B9U);
  EXPECT_EQ(d.period_s, 0.01);
  EXPECT_EQ(d.late + d.missing, 0U);
  EXPECT_GT(d.retransmitted, 0U);
  ASSERT_EQ(d.motions.size(), 8U);
  for (const auto& [device, motions] : d.motions) {
    std::array<char, 9> name{};
    std::snprintf(name.data(), name.size(), "%08X", device);
    WAYFARE_NEEDS_RECORDING(text_path, base + "-000_" + std::string(name.data()) + ".txt.gz");
    std::map<unsigned, const AwindaMotion*> by_counter;
    for (const AwindaMotion& m : motions) by_counter[m.frame & 0xFFFFU] = &m;
    const std::vector<Row> rows = exported(text_path);
    ASSERT_GT(rows.size(), 1500U);
    double worst = 0.0;
    std::size_t found = 0;
    for (const Row& row : rows) {
      const auto m = by_counter.find(row.counter);
      if (m == by_counter.end()) continue;
      ++found;
      for (int i = 0; i < 3; ++i) {
        const auto k = static_cast<std::size_t>(i);
        worst = std::max({worst, std::abs(m->second->acceleration_mps2[i] - row.values[k]),
                          std::abs(m->second->rate_radps[i] - row.values[3 + k]),
                          std::abs(m->second->field_au[i] - row.values[6 + k])});
      }
    }
    EXPECT_EQ(found, rows.size()) << name.data();
    EXPECT_LT(worst, 1e-6) << name.data();  // half of the last digit printed is 5e-7
  }
}

TEST(AwindaCaptures, StandingAsExported) { expect_export("Static/pose1", 12582); }
TEST(AwindaCaptures, LungesAsExported) { expect_export("Dynamic/Lunges", 17813); }

TEST(AwindaCaptures, SecondPose) {
  WAYFARE_NEEDS_RECORDING(path, "devices/xsens/awinda_mtb/Static/pose2/MT_012012B9_000.mtb.gz");
  const Decoded d = decode_log(path);
  EXPECT_EQ(d.statistics.frames, 16733U);
  EXPECT_EQ(d.statistics.skipped_bytes, 0U);
  EXPECT_EQ(d.snapshots, 16672U);
  EXPECT_EQ(d.late + d.missing, 0U);
  for (const auto& [device, motions] : d.motions)
    for (const AwindaMotion& m : motions) EXPECT_NEAR(m.acceleration_mps2.norm(), 9.81, 1.5);
}

}  // namespace
}  // namespace wayfare::decode
