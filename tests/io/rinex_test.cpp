#include <wayfare/io/rinex.hpp>

#include <cmath>
#include <string>
#include <variant>

#include <wayfare/gnss/ephemerides.hpp>
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

RinexNavigation navigation(const std::string& text) {
  Result<RinexNavigation> file = parse_rinex_navigation(text, "n");
  EXPECT_TRUE(file) << file.error().to_string();
  return file ? *std::move(file) : RinexNavigation{};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  return text.replace(at, from.size(), to);
}

Time<GpsClock> gps(int hour, int minute, Duration of_minute) {
  return *gps_from_civil({2019, 4, 28, hour, minute, of_minute});
}

const KeplerianEphemeris& keplerian(const RinexNavigation& nav, const char* satellite,
                                    std::size_t i = 0) {
  return std::get<KeplerianEphemeris>(nav.ephemerides.of(*parse_satellite(satellite)).at(i));
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

TEST(RinexNavigation, Version3Mixed) {
  const RinexNavigation nav = navigation(rinex_3_navigation());
  EXPECT_TRUE(nav.problems.empty()) << nav.problems.first().front().to_string();
  EXPECT_EQ(nav.messages, 4U);
  EXPECT_EQ(nav.other_messages, 1U);
  EXPECT_EQ(nav.ephemerides.leap_seconds, 18);
  ASSERT_TRUE(nav.ephemerides.gps_ionosphere);
  EXPECT_DOUBLE_EQ(nav.ephemerides.gps_ionosphere->alpha[3], -1.1921e-07);
  EXPECT_DOUBLE_EQ(nav.ephemerides.gps_ionosphere->beta[0], 8.8064e+04);
  EXPECT_FALSE(nav.ephemerides.beidou_ionosphere);

  const KeplerianEphemeris& g = keplerian(nav, "G02");
  EXPECT_EQ(g.toe, gps(12, 0, Duration(0)));
  EXPECT_EQ(g.toc, g.toe);
  EXPECT_DOUBLE_EQ(g.clock_bias_s, -1.99e-04);
  EXPECT_DOUBLE_EQ(g.crs_m, -37.75);
  EXPECT_DOUBLE_EQ(g.eccentricity, 1.89e-02);
  EXPECT_DOUBLE_EQ(g.sqrt_semi_major_axis, 5153.694378);
  EXPECT_DOUBLE_EQ(g.argument_of_perigee_rad, -1.746);
  EXPECT_DOUBLE_EQ(g.group_delay_s[0], -2.05e-08);
  EXPECT_DOUBLE_EQ(g.group_delay_s[1], 0.0);  // IODC is in its field
  EXPECT_TRUE(is_healthy(g, carrier::kL1));
  EXPECT_FALSE(is_healthy(keplerian(nav, "G02", 1), carrier::kL1));
  // BeiDou's clocks are 14 s behind.
  EXPECT_EQ(keplerian(nav, "C11").toe, gps(12, 0, std::chrono::seconds(14)));

  const auto& r = std::get<GlonassEphemeris>(nav.ephemerides.of(*parse_satellite("R02")).at(0));
  EXPECT_EQ(r.toe, gps(12, 15, std::chrono::seconds(18)));
  EXPECT_EQ(r.channel, -4);
  EXPECT_DOUBLE_EQ(r.position_m.y(), -15000e3);
  EXPECT_DOUBLE_EQ(r.velocity_mps.z(), 700.0);
  EXPECT_DOUBLE_EQ(r.clock_bias_s, 5.5e-05);
}

TEST(RinexNavigation, NearestMessage) {
  const RinexNavigation nav = navigation(rinex_3_navigation());
  const SatelliteId g02 = *parse_satellite("G02");
  EXPECT_EQ(reference_time(*nav.ephemerides.nearest(g02, gps(12, 50, Duration(0)))),
            gps(12, 0, Duration(0)));
  EXPECT_EQ(reference_time(*nav.ephemerides.nearest(g02, gps(13, 10, Duration(0)))),
            gps(14, 0, Duration(0)));
  EXPECT_EQ(nav.ephemerides.nearest(*parse_satellite("G09"), gps(12, 0, Duration(0))), nullptr);
}

TEST(RinexNavigation, Version2) {
  const RinexNavigation nav = navigation(rinex_2_navigation());
  EXPECT_TRUE(nav.problems.empty()) << nav.problems.first().front().to_string();
  const KeplerianEphemeris& two = keplerian(nav, "G02");
  const RinexNavigation nav_3 = navigation(rinex_3_navigation());
  const KeplerianEphemeris& three = keplerian(nav_3, "G02");
  EXPECT_EQ(two.toe, three.toe);
  EXPECT_DOUBLE_EQ(two.cis_rad, three.cis_rad);
  EXPECT_DOUBLE_EQ(two.inclination_rate_radps, three.inclination_rate_radps);
  EXPECT_DOUBLE_EQ(nav.ephemerides.gps_ionosphere->alpha[0], 0.9313e-08);
  EXPECT_DOUBLE_EQ(nav.ephemerides.gps_ionosphere->beta[3], -0.3277e+06);
}

TEST(RinexNavigation, Version2Glonass) {
  std::string text =
      rinex_header("     2.11           G: GLONASS NAV DATA", "RINEX VERSION / TYPE");
  text += rinex_header("", "END OF HEADER");
  text += rinex_message(" 2 19  4 28 12 15  0.0", {5.5e-05, 1.8e-12, 43200.0});
  text += rinex_glonass_lines(3, 5.0);
  const RinexNavigation nav = navigation(text);
  EXPECT_TRUE(nav.problems.empty()) << nav.problems.first().front().to_string();
  const auto& r = std::get<GlonassEphemeris>(nav.ephemerides.of(*parse_satellite("R02")).at(0));
  EXPECT_EQ(r.toe, gps(12, 15, std::chrono::seconds(18)));
  EXPECT_EQ(r.channel, 5);
}

TEST(RinexNavigation, DamagedMessagesAffectOnlyThemselves) {
  const std::string good = rinex_3_navigation();
  const auto expect_problem = [&](const std::string& from, const std::string& to,
                                  const std::string& text, std::size_t messages, std::size_t line) {
    const RinexNavigation nav = navigation(replaced(good, from, to));
    EXPECT_EQ(nav.messages, messages) << text;
    ASSERT_FALSE(nav.problems.empty()) << text;
    EXPECT_THAT(nav.problems.first()[0].message, HasSubstr(text));
    EXPECT_EQ(nav.problems.first()[0].line, line) << text;
  };
  expect_problem("5.153694378000D+03", "5.1536943x8000D+03", "not a number", 3, 8);
  expect_problem("5.153694378000D+03", "0.000000000000D+00", "orbit's size", 3, 6);
  expect_problem("5.153694378000D+03", std::string(18, ' '), "missing or not finite", 3, 6);
  expect_problem("1.890000000000D-02", "9.890000000000D-01", "eccentricity", 3, 6);
  expect_problem("2.051000000000D+03", "2.059000000000D+03", "week 2059 is inconsistent with", 3,
                 6);
  expect_problem("4.320000000000D+04", "8.300000000000D+05", "time of week", 3, 6);
  expect_problem("4.320000000000D+04", "4.320000000000D+05", "not near the clock's date", 3, 6);
  expect_problem("2019 04 28 12 00 00", "2019 02 30 12 00 00", "date does not exist", 3, 6);
  // A message without its last four lines.
  const std::size_t from = good.find("C11"), to = good.find("R02");
  std::string cut = good.substr(0, from + std::size_t{5} * 81);
  cut += '\n';
  cut += good.substr(to);
  const RinexNavigation nav = navigation(cut);
  EXPECT_EQ(nav.messages, 3U);
  EXPECT_FALSE(nav.problems.empty());
}

TEST(RinexNavigation, WeeksWithoutTheirRollOvers) {
  const RinexNavigation nav =
      navigation(replaced(rinex_3_navigation(), "2.051000000000D+03", "3.000000000000D+00"));
  EXPECT_EQ(nav.messages, 4U);
  EXPECT_EQ(keplerian(nav, "G02").toe, gps(12, 0, Duration(0)));
}

TEST(RinexNavigation, RejectsOtherFiles) {
  EXPECT_FALSE(parse_rinex_navigation("", "n"));
  EXPECT_FALSE(parse_rinex_navigation("not a file\n", "n"));
  const auto observation = parse_rinex_navigation(rinex_3_observations(), "n");
  ASSERT_FALSE(observation);
  EXPECT_THAT(observation.error().to_string(), HasSubstr("n:1: is not a RINEX navigation file"));
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

TEST(RinexRecordings, NavigationFiles) {
  WAYFARE_NEEDS_RECORDING(walk, "gnss/walk_0827/walk.nav");
  const Result<RinexNavigation> nav = read_rinex_navigation(walk);
  ASSERT_TRUE(nav);
  EXPECT_EQ(nav->messages, 12U);       // four of GPS, eight of BeiDou
  EXPECT_EQ(nav->other_messages, 5U);  // SBAS
  EXPECT_EQ(nav->ephemerides.satellites().size(), 12U);
  EXPECT_TRUE(nav->problems.empty());
}

}  // namespace
}  // namespace wayfare::io
