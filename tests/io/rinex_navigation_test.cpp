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
using ::testing::HasSubstr;

RinexNavigation navigation(const std::string& text) {
  Result<RinexNavigation> file = parse_rinex_navigation(text, "n");
  EXPECT_TRUE(file) << file.error().to_string();
  return file ? *std::move(file) : RinexNavigation{};
}

const KeplerianEphemeris& keplerian(const RinexNavigation& nav, const char* satellite,
                                    std::size_t i = 0) {
  return std::get<KeplerianEphemeris>(nav.ephemerides.of(*parse_satellite(satellite)).at(i));
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
