// Raw observations of u-blox streams.

#include <wayfare/io/observations.hpp>

#include <cmath>
#include <map>
#include <string>

#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/rinex.hpp>

#include "decode/captures.hpp"
#include "gnss/subframe_writer.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;

std::string as_text(const decode::UbxBytes& bytes) { return {bytes.begin(), bytes.end()}; }

TEST(UbxObservations, OneSignalOfEachSatellite) {
  auto all = decode::sample_measurements();
  decode::UbxMeasurement l2 = all[0], invalid = all[0], sbas = all[0], beidou = all[0];
  l2.signal = 3;
  invalid.satellite = 18, invalid.pseudorange_valid = false;
  sbas.gnss = decode::UbxGnss::sbas, sbas.satellite = 131;
  beidou.gnss = decode::UbxGnss::beidou, beidou.satellite = 30, beidou.carrier_phase_valid = false;
  for (const auto& m : {l2, invalid, sbas, beidou}) all.push_back(m);
  const auto file =
      parse_observations(as_text(decode::rawx({345678.25, 2200, 18, true, false}, all)), "x.ubx");
  ASSERT_TRUE(file) << file.error().to_string();
  ASSERT_EQ(file->epochs.size(), 1U);
  const ObservationEpoch& epoch = file->epochs.front();
  EXPECT_EQ(epoch.time, gps_time(2200, from_seconds(345678.25)));
  ASSERT_EQ(epoch.satellites.size(), 4U);
  EXPECT_EQ(to_string(epoch.satellites[0].satellite), "G17");
  EXPECT_EQ(epoch.satellites[0].pseudorange_m, 21'234'567.875);
  EXPECT_EQ(epoch.satellites[0].carrier_cycles, 111'587'345.125);
  EXPECT_EQ(epoch.satellites[0].doppler_hz, -1234.5);
  EXPECT_EQ(epoch.satellites[0].cn0_dbhz, 47.0);
  EXPECT_EQ(to_string(epoch.satellites[1].satellite), "E31");
  EXPECT_EQ(epoch.satellites[2].carrier_hz, carrier::kGlonassL1 - 3 * carrier::kGlonassL1Step);
  EXPECT_TRUE(std::isnan(epoch.satellites[2].carrier_cycles));
  EXPECT_EQ(epoch.satellites[3].carrier_hz, carrier::kB1I);
}

TEST(UbxObservations, LockTimesTellInterruptedPhases) {
  auto all = decode::sample_measurements();
  all.resize(1);
  std::string bytes;
  const auto add = [&](double time_s, double lock_s, bool resolved) {
    all[0].lock_time_s = lock_s, all[0].half_cycle_resolved = resolved;
    bytes += as_text(decode::rawx({time_s, 2200, 18, true, false}, all));
  };
  add(100.0, 64.5, true);  // the first: nothing before it
  add(101.0, 64.5, true);  // tracked
  add(102.0, 0.4, true);   // lost and found within the second
  add(103.0, 1.4, true);   // tracked
  add(104.0, 2.4, false);  // half cycles unknown
  add(114.0, 9.9, true);   // lost in the gap
  const auto file = parse_observations(bytes, "x.ubx");
  ASSERT_TRUE(file) << file.error().to_string();
  const std::vector<bool> expected = {true, false, true, false, true, true};
  ASSERT_EQ(file->epochs.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_EQ(file->epochs[i].satellites[0].phase_interrupted, expected[i]) << i;
}

TEST(UbxObservations, StreamsWithoutRangesAreNamed) {
  const auto file = parse_observations(
      as_text(decode::ubx(decode::UbxId::nav_pvt, decode::UbxBytes(92))), "pvt.ubx");
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().to_string(), HasSubstr("pvt.ubx: contains no RXM-RAWX"));
  EXPECT_FALSE(parse_observations("", "empty"));
  const auto bad = parse_observations(
      as_text(decode::rawx({std::nan(""), 2200, 18, true, false}, decode::sample_measurements())),
      "nan.ubx");
  EXPECT_FALSE(bad);
}

/// The recorded bytes and what RTKLIB made of them: walk.obs and walk.nav, as their headers say.
TEST(UbxObservations, RecordedBytesAsRtklibConvertsThem) {
  WAYFARE_NEEDS_RECORDING(ubx_path, "gnss/walk_0827/gnss_1730.ubx.gz");
  WAYFARE_NEEDS_RECORDING(obs_path, "gnss/walk_0827/walk.obs.gz");
  const auto ours = read_observations(ubx_path), theirs = read_observations(obs_path);
  ASSERT_TRUE(ours) << ours.error().to_string();
  ASSERT_TRUE(theirs) << theirs.error().to_string();
  ASSERT_EQ(ours->epochs.size(), 536U);
  ASSERT_EQ(theirs->epochs.size(), 536U);
  std::size_t compared = 0, ours_alone = 0;
  for (std::size_t i = 0; i < ours->epochs.size(); ++i) {
    const ObservationEpoch &a = ours->epochs[i], &b = theirs->epochs[i];
    EXPECT_LT(std::abs(to_seconds(a.time - b.time)), 1e-6);
    std::map<SatelliteId, SatelliteObservation> of_b;
    for (const auto& o : b.satellites) of_b[o.satellite] = o;
    for (const auto& o : a.satellites) {
      const auto other = of_b.find(o.satellite);
      if (other == of_b.end()) {
        ++ours_alone;
        continue;
      }
      ++compared;
      EXPECT_NEAR(o.pseudorange_m, other->second.pseudorange_m, 5.1e-4);
      EXPECT_NEAR(o.doppler_hz, other->second.doppler_hz, 5.1e-4);
      EXPECT_NEAR(o.cn0_dbhz, other->second.cn0_dbhz, 1e-9);
      of_b.erase(other);
    }
    for (const auto& [satellite, o] : of_b) EXPECT_TRUE(std::isnan(o.pseudorange_m)) << i;
  }
  EXPECT_GT(compared, 6000U);
  EXPECT_EQ(ours_alone, 0U);
}

TEST(UbxObservations, RecordedMessagesOfGpsAsRtklibConvertsThem) {
  WAYFARE_NEEDS_RECORDING(ubx_path, "gnss/walk_0827/gnss_1730.ubx.gz");
  WAYFARE_NEEDS_RECORDING(nav_path, "gnss/walk_0827/walk.nav");
  const auto ours = read_observations(ubx_path);
  const auto theirs = read_rinex_navigation(nav_path);
  ASSERT_TRUE(ours && theirs);
  std::size_t compared = 0;
  for (const SatelliteId s : ours->ephemerides.satellites()) {
    for (const Ephemeris& message : ours->ephemerides.of(s)) {
      const Ephemeris* other = theirs->ephemerides.nearest(s, reference_time(message));
      ASSERT_NE(other, nullptr);
      ASSERT_EQ(reference_time(*other), reference_time(message));
      ++compared;
      const auto a = satellite_state(message, reference_time(message) + std::chrono::hours(1));
      const auto b = satellite_state(*other, reference_time(message) + std::chrono::hours(1));
      // RINEX has twelve digits of each number.
      EXPECT_LT((a.position_ecef_m - b.position_ecef_m).norm(), 1e-3);
      EXPECT_NEAR(a.clock_s, b.clock_s, 1e-15);
    }
  }
  std::size_t gps = 0;
  for (const SatelliteId s : theirs->ephemerides.satellites())
    if (s.system == GnssSystem::gps) gps += theirs->ephemerides.of(s).size();
  EXPECT_EQ(compared, gps);
}

}  // namespace
}  // namespace wayfare::io
