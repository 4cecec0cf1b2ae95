#include <wayfare/io/rinex.hpp>

#include <cmath>
#include <string>

#include "rinex_samples.hpp"
#include "support.hpp"

namespace wayfare::io {
namespace {

using namespace wayfare::testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

RinexObservations observations(const std::string& text, const RinexOptions& options = {}) {
  Result<RinexObservations> file = parse_rinex_observations(text, "o", options);
  EXPECT_TRUE(file) << file.error().to_string();
  return file ? *std::move(file) : RinexObservations{};
}

TEST(RinexObservations, Version3) {
  const RinexObservations file = observations(rinex_3_observations());
  EXPECT_DOUBLE_EQ(file.version, 3.04);
  EXPECT_EQ(file.marker, "ROVER");
  EXPECT_DOUBLE_EQ(file.approximate_position_ecef_m->y(), 5385498.5603);
  EXPECT_DOUBLE_EQ(file.antenna_up_east_north_m.x(), 1.5);
  EXPECT_EQ(file.leap_seconds, 18);
  EXPECT_TRUE(file.problems.empty()) << file.problems.first().front().to_string();
  ASSERT_EQ(file.epochs.size(), 3U);
  const ObservationEpoch& epoch = file.epochs[0];
  EXPECT_EQ(epoch.time, gps(12, 44, Duration(33997000000)));
  ASSERT_EQ(epoch.satellites.size(), 3U);
  EXPECT_EQ(to_string(epoch.satellites[0].satellite), "G02");
  EXPECT_DOUBLE_EQ(epoch.satellites[0].pseudorange_m, 21600712.022);
  EXPECT_DOUBLE_EQ(epoch.satellites[0].doppler_hz, 445.146);
  EXPECT_TRUE(std::isnan(epoch.satellites[0].carrier_cycles));
  EXPECT_DOUBLE_EQ(epoch.satellites[0].cn0_dbhz, 27.0);
  EXPECT_DOUBLE_EQ(epoch.satellites[0].carrier_hz, 1575.42e6);
  // Slot 2 transmits on channel −4 by the header: 1602 − 4 · 0.5625 MHz.
  EXPECT_DOUBLE_EQ(epoch.satellites[1].carrier_hz, 1599.75e6);
  EXPECT_EQ(to_string(epoch.satellites[2].satellite), "C11");
  EXPECT_DOUBLE_EQ(epoch.satellites[2].carrier_hz, 1561.098e6);
  EXPECT_TRUE(std::isnan(epoch.satellites[2].doppler_hz));
  EXPECT_EQ(file.other_satellites, 1U);  // J01
  EXPECT_EQ(file.no_signal, 1U);         // G08 has only its second band
}

TEST(RinexObservations, SignalsByPreference) {
  RinexOptions options;
  options.signals[0] = {"1C", "2W"};
  const RinexObservations both = observations(rinex_3_observations(), options);
  ASSERT_EQ(both.epochs[0].satellites.size(), 4U);
  EXPECT_DOUBLE_EQ(both.epochs[0].satellites[0].carrier_hz, 1575.42e6);
  EXPECT_EQ(to_string(both.epochs[0].satellites[2].satellite), "G08");
  EXPECT_DOUBLE_EQ(both.epochs[0].satellites[2].pseudorange_m, 22846861.832);
  EXPECT_DOUBLE_EQ(both.epochs[0].satellites[2].carrier_hz, 1227.60e6);
  options.signals[0] = {};
  EXPECT_EQ(observations(rinex_3_observations(), options).epochs[0].satellites.size(), 2U);
}

TEST(RinexObservations, Version2WithContinuationLines) {
  const RinexObservations file = observations(rinex_2_observations());
  EXPECT_TRUE(file.problems.empty()) << file.problems.first().front().to_string();
  ASSERT_EQ(file.epochs.size(), 3U);
  for (const ObservationEpoch& epoch : file.epochs) ASSERT_EQ(epoch.satellites.size(), 14U);
  EXPECT_EQ(file.epochs[1].time,
            *gps_from_civil({2006, 1, 1, 0, 0, std::chrono::milliseconds(1250)}));
  const SatelliteObservation& second = file.epochs[2].satellites[1];
  EXPECT_EQ(to_string(second.satellite), "G02");  // " 2" is GPS
  EXPECT_DOUBLE_EQ(second.pseudorange_m, 2.1e7 + 2);
  EXPECT_DOUBLE_EQ(second.carrier_cycles, 1.1e8 + 2);
  EXPECT_DOUBLE_EQ(second.doppler_hz, 200.0);
  EXPECT_DOUBLE_EQ(second.cn0_dbhz, 42.0);
  EXPECT_EQ(to_string(file.epochs[0].satellites[13].satellite), "R14");
  RinexOptions options;
  options.signals[0] = {"2W"};  // P2, whose phase L2 is on the second line
  const SatelliteObservation p2 =
      observations(rinex_2_observations(), options).epochs[0].satellites[0];
  EXPECT_DOUBLE_EQ(p2.pseudorange_m, 2.1e7 + 2);
  EXPECT_DOUBLE_EQ(p2.carrier_cycles, 9e7 + 1);
}

// The digit after a phase: bit 0 loss of lock, bit 1 half cycles unknown, bit 2 not of interest.
TEST(RinexObservations, LossOfLockIndicators) {
  const std::string header =
      "     3.04           OBSERVATION DATA    G: GPS              RINEX VERSION / TYPE\n"
      "G    2 C1C L1C                                              SYS / # / OBS TYPES\n"
      "                                                            END OF HEADER\n";
  std::string text = header;
  const std::string indicators = " 0123457";
  text += "> 2019  4 28 12 44 30.0000000  0  8\n";
  for (std::size_t i = 0; i < indicators.size(); ++i)
    text += "G0" + std::to_string(i + 1) + "  21600712.022   113512506.876" + indicators[i] + "7\n";
  text += "> 2019  4 28 12 44 31.0000000  1  1\nG01  21600712.022   113512506.876\n";
  const RinexObservations file = observations(text);
  ASSERT_EQ(file.epochs.size(), 2U);
  ASSERT_EQ(file.epochs[0].satellites.size(), 8U);
  const std::vector<bool> expected = {false, false, true, true, true, false, true, true};
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(file.epochs[0].satellites[i].phase_interrupted, expected[i]) << indicators[i];
    EXPECT_DOUBLE_EQ(file.epochs[0].satellites[i].carrier_cycles, 113512506.876);
  }
  // After a power failure all phases begin anew.
  EXPECT_TRUE(file.epochs[1].satellites[0].phase_interrupted);
}

TEST(RinexObservations, TimeSystems) {
  const std::string text = rinex_3_observations();
  const Time<GpsClock> t = gps(12, 44, Duration(33997000000));
  EXPECT_EQ(observations(replaced(text, "     GPS    ", "     BDT    ")).epochs[0].time,
            t + std::chrono::seconds(14));
  EXPECT_EQ(observations(replaced(text, "     GPS    ", "     GLO    ")).epochs[0].time,
            t + std::chrono::seconds(18));
  EXPECT_EQ(observations(replaced(text, "     GPS    ", "     GAL    ")).epochs[0].time, t);
  RinexOptions options;
  options.leap_seconds = {{Time<UtcClock>(), 25}};
  EXPECT_EQ(observations(replaced(text, "     GPS    ", "     GLO    "), options).epochs[0].time,
            t + std::chrono::seconds(25));
}

TEST(RinexObservations, Events) {
  // A power failure before an epoch; new types in the middle; an external event without satellites;
  // an event without a time.
  std::string text = rinex_3_header();
  text += "> 2019 04 28 12 44 33.0000000  1  1\n";
  text += rinex_3_satellite("G02", 2.1e7, 1.0, 40.0);
  text += "> 2019 04 28 12 44 33.5000000  4  1\n";
  text += rinex_header("G    2 S1C C1C", "SYS / # / OBS TYPES");
  text += "> 2019 04 28 12 44 33.7000000  5  0\n>                              3  1\n";
  text += rinex_header("SECOND", "MARKER NAME");
  text += "> 2019 04 28 12 44 34.0000000  0  1\nG02";
  text += rinex_value(41.0);
  text += "  ";
  text += rinex_value(2.2e7);
  text += '\n';
  const RinexObservations file = observations(text);
  EXPECT_TRUE(file.problems.empty()) << file.problems.first().front().to_string();
  ASSERT_EQ(file.epochs.size(), 2U);
  ASSERT_EQ(file.events.size(), 4U);
  EXPECT_EQ(file.events[0].flag, 1);
  EXPECT_EQ(file.events[1].flag, 4);
  EXPECT_EQ(file.events[2].time, gps(12, 44, std::chrono::milliseconds(33700)));
  EXPECT_FALSE(file.events[3].time);
  EXPECT_EQ(file.marker, "SECOND");
  EXPECT_DOUBLE_EQ(file.epochs[1].satellites.at(0).pseudorange_m, 2.2e7);
  EXPECT_DOUBLE_EQ(file.epochs[1].satellites.at(0).cn0_dbhz, 41.0);
}

TEST(RinexObservations, ADamagedEpochAffectsOnlyItself) {
  const std::string text = rinex_3_observations();
  const RinexObservations file = observations(
      replaced(text, "> 2019 04 28 12 44 34.9970000", "> 2019 04 31 12 44 34.9970000"));
  EXPECT_EQ(file.epochs.size(), 2U);
  EXPECT_EQ(file.skipped_epochs, 1U);
  ASSERT_EQ(file.problems.count(), 1U);
  EXPECT_EQ(file.problems.first()[0].line, 18U);
  EXPECT_EQ(file.problems.first()[0].source, "o");
}

TEST(RinexObservations, ADamagedSatelliteAffectsOnlyItself) {
  const std::string text = rinex_3_observations();
  const RinexObservations file = observations(replaced(text, "  21600712.022", "  2160071x.022"));
  ASSERT_EQ(file.epochs.size(), 3U);
  EXPECT_EQ(file.epochs[0].satellites.size(), 2U);
  EXPECT_THAT(file.problems.first().at(0).message, HasSubstr("2160071x.022"));
  EXPECT_EQ(file.problems.first()[0].line, 13U);
  // A satellite's name is damaged.
  EXPECT_EQ(
      observations(replaced(text, "R02  20672491", "Q0! 20672491")).epochs[0].satellites.size(),
      2U);
}

TEST(RinexObservations, ATruncatedFileKeepsItsWholeEpochs) {
  const std::string text = rinex_3_observations();
  for (std::size_t size = text.size() - 150; size < text.size(); ++size) {
    const Result<RinexObservations> file = parse_rinex_observations(text.substr(0, size), "o");
    ASSERT_TRUE(file);
    ASSERT_GE(file->epochs.size(), 2U);
    for (const ObservationEpoch& epoch : file->epochs)
      for (const SatelliteObservation& o : epoch.satellites)
        if (to_string(o.satellite) == "G02") {
          EXPECT_NEAR(o.pseudorange_m, 21600600.0, 200.0) << size;  // never a part of a number
        }
  }
  // An epoch that ends early because the next one begins keeps its satellites.
  const RinexObservations early =
      observations(replaced(text, "34.9970000  0  1", "34.9970000  0  5"));
  EXPECT_EQ(early.epochs.size(), 3U);
  EXPECT_EQ(early.epochs[1].satellites.size(), 1U);
  EXPECT_THAT(early.problems.first().at(0).message, HasSubstr("1 of 5 satellites"));
}

TEST(RinexObservations, RejectsOtherFiles) {
  const auto fails = [](const std::string& text, const std::string& expected) {
    const Result<RinexObservations> file = parse_rinex_observations(text, "o");
    ASSERT_FALSE(file) << text.substr(0, 100);
    EXPECT_THAT(file.error().to_string(), HasSubstr(expected));
  };
  fails("", "is not RINEX");
  fails("Raw,1,2,3\n", "o:1: is not RINEX");
  fails(rinex_3_navigation(), "not a RINEX observation file");
  fails(rinex_header("     4.00           OBSERVATION DATA    M", "RINEX VERSION / TYPE"), "4.00");
  fails(rinex_header("     3.04           OBSERVATION DATA    M", "RINEX VERSION / TYPE"),
        "the header has no end");
  fails(rinex_3_header(), "contains no epoch");
}

TEST(RinexRecordings, ReadWithoutProblems) {
  struct Recorded {
    const char* obs;
    std::size_t epochs;
  };
  for (const Recorded& r :
       {Recorded{"gnss/urbannav_tst/COM3_190428_124409.obs.gz", 1760},
        Recorded{"gnss/stuttgart_city/stuttgart_city.obs.gz", 1518},
        Recorded{"gnss/walk_0827/walk.obs.gz", 536},
        Recorded{"gnss/instinct_spirent_dyn/iono-none_tropo-none/Rover-dynamic_MO_Spirent.obs.gz",
                 601}}) {
    WAYFARE_NEEDS_RECORDING(path, r.obs);
    const Result<RinexObservations> file = read_rinex_observations(path);
    ASSERT_TRUE(file) << file.error().to_string();
    EXPECT_EQ(file->epochs.size(), r.epochs) << r.obs;  // lines that begin with '>'
    EXPECT_TRUE(file->problems.empty()) << file->problems.first().front().to_string();
  }
}

}  // namespace
}  // namespace wayfare::io
