// Orbits, clocks and atmosphere against RTKLIB's library, on recorded navigation files.

#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <wayfare/core/angle.hpp>
#include <wayfare/gnss/correct_ranges.hpp>
#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/io/rinex.hpp>
#include "io/support.hpp"
#include "rtklib.hpp"

// Progress callbacks required by the library.
extern "C" {
int showmsg(const char*, ...) { return 0; }
void settspan(gtime_t, gtime_t) {}
void settime(gtime_t) {}
}

namespace wayfare {
namespace {

constexpr double kC = kSpeedOfLight_mps;

gtime_t of(Time<GpsClock> t) {
  const WeekTime w = week_time(t);
  const auto whole = std::chrono::floor<std::chrono::seconds>(w.of_week);
  gtime_t g = gpst2time(w.week, static_cast<double>(whole.count()));
  g.sec = to_seconds(w.of_week - whole);
  return g;
}

int number_of(SatelliteId s) {
  constexpr int kSystem[] = {0x01, 0x04, 0x08, 0x20};
  return satno(kSystem[index_of(s.system)], s.number);
}

eph_t of(const KeplerianEphemeris& k) {
  eph_t e{};
  e.sat = number_of(k.satellite);
  e.toe = of(k.toe), e.toc = of(k.toc);
  const bool beidou = k.satellite.system == GnssSystem::beidou;
  const WeekTime w = week_time(beidou ? k.toe - kGpsMinusBeidou : k.toe);
  e.week = w.week, e.toes = to_seconds(w.of_week);
  e.A = k.sqrt_semi_major_axis * k.sqrt_semi_major_axis, e.e = k.eccentricity;
  e.i0 = k.inclination_rad, e.OMG0 = k.ascending_node_rad, e.omg = k.argument_of_perigee_rad;
  e.M0 = k.mean_anomaly_rad, e.deln = k.mean_motion_difference_radps;
  e.OMGd = k.ascending_node_rate_radps, e.idot = k.inclination_rate_radps;
  e.crc = k.crc_m, e.crs = k.crs_m, e.cuc = k.cuc_rad, e.cus = k.cus_rad;
  e.cic = k.cic_rad, e.cis = k.cis_rad;
  e.f0 = k.clock_bias_s, e.f1 = k.clock_drift, e.f2 = k.clock_drift_rate_per_s;
  return e;
}

SatelliteState oracle(const KeplerianEphemeris& k, Time<GpsClock> t) {
  const eph_t e = of(k);
  SatelliteState s;
  double variance = 0.0;
  eph2pos(of(t), &e, s.position_ecef_m.data(), &s.clock_s, &variance);
  return s;
}

TEST(Rtklib, MatchesTheDeclarations) {
  EXPECT_GT(satno(0x01, 5), 0);
  const gtime_t t = gpst2time(2051, 46690.0);  // 2019-04-28T12:58:10, by date -u
  EXPECT_EQ(t.time, 315964800 + 2051LL * 604800 + 46690);
  // A circular equatorial orbit of 26 560 km above Greenwich, at its reference time.
  KeplerianEphemeris k;
  k.satellite = {GnssSystem::gps, 1};
  k.toe = k.toc = gps_time(2051, Duration(0));
  k.sqrt_semi_major_axis = std::sqrt(26560e3);
  k.clock_bias_s = 1e-4;
  const SatelliteState s = oracle(k, k.toe);
  EXPECT_NEAR((s.position_ecef_m - Eigen::Vector3d(26560e3, 0, 0)).norm(), 0.0, 1e-6);
  EXPECT_NEAR(s.clock_s, 1e-4, 1e-18);
}

/// All messages of a file at times up to the age limit, before and after.
void compare(const std::string& path, GnssSystem system, std::size_t at_least) {
  const auto nav = io::read_rinex_navigation(path);
  ASSERT_TRUE(nav) << nav.error().to_string();
  EXPECT_TRUE(nav->problems.empty()) << nav->problems.first().front().to_string();
  std::size_t compared = 0;
  std::set<int> numbers;
  double worst_m = 0.0, worst_clock_m = 0.0, worst_mps = 0.0;
  for (const SatelliteId satellite : nav->ephemerides.satellites()) {
    if (satellite.system != system) continue;
    numbers.insert(satellite.number);
    for (const Ephemeris& message : nav->ephemerides.of(satellite)) {
      const auto& k = std::get<KeplerianEphemeris>(message);
      for (double dt = -7200.0; dt <= 7200.0; dt += 611.0) {
        const Time<GpsClock> t = k.toe + from_seconds(dt + 0.123456789);
        const SatelliteState ours = satellite_state(k, t), theirs = oracle(k, t);
        worst_m = std::max(worst_m, (ours.position_ecef_m - theirs.position_ecef_m).norm());
        worst_clock_m = std::max(worst_clock_m, kC * std::abs(ours.clock_s - theirs.clock_s));
        // RTKLIB has no velocities; a central difference of its positions over 0.2 s has 1e-9 m /
        // 0.2 s of rounding and 0.1²/6 s² × 0.006 m/s³ of truncation.
        const Duration h = std::chrono::milliseconds(100);
        const Eigen::Vector3d rate =
            (oracle(k, t + h).position_ecef_m - oracle(k, t - h).position_ecef_m) / 0.2;
        worst_mps = std::max(worst_mps, (ours.velocity_ecef_mps - rate).norm());
        ++compared;
      }
    }
  }
  EXPECT_GE(numbers.size(), at_least);
  EXPECT_LT(worst_m, 1e-4) << compared;
  EXPECT_LT(worst_clock_m, 1e-6);
  EXPECT_LT(worst_mps, 1e-4);
  ::testing::Test::RecordProperty("compared", static_cast<int>(compared));
  ::testing::Test::RecordProperty("worst_position_m", std::to_string(worst_m));
}

TEST(Rtklib, GpsOrbitsAndClocks) {
  WAYFARE_NEEDS_RECORDING(path, "gnss/urbannav_tst/hksc1180.19n");
  compare(path, GnssSystem::gps, 30);
}

TEST(Rtklib, GalileoOrbitsAndClocks) {
  WAYFARE_NEEDS_RECORDING(path, "gnss/instinct_spirent_dyn/RINEX_EN_Spirent.23L");
  compare(path, GnssSystem::galileo, 20);
}

TEST(Rtklib, BeidouOrbitsAndClocksIncludingGeostationary) {
  WAYFARE_NEEDS_RECORDING(path, "gnss/urbannav_tst/hksc1180.19b");
  compare(path, GnssSystem::beidou, 15);
}

TEST(Rtklib, GlonassOrbitsAndClocks) {
  // Without a recorded GLONASS message: orbits of its size in all positions.
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 50; ++i) {
    GlonassEphemeris g;
    g.satellite = {GnssSystem::glonass, static_cast<std::uint8_t>(1 + i % 24)};
    g.toe = gps_time(2051, std::chrono::minutes(15 + 30 * i) + std::chrono::seconds(18));
    const Eigen::Vector3d up = Eigen::Vector3d(normal(random), normal(random), normal(random));
    g.position_m = 25.5e6 * up.normalized();
    g.velocity_mps =
        3.4e3 * up.cross(Eigen::Vector3d(normal(random), normal(random), 1.0)).normalized();
    g.acceleration_mps2 = 1e-6 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    g.clock_bias_s = 1e-4 * normal(random), g.clock_drift = 1e-12 * normal(random);
    geph_t theirs{};
    theirs.sat = number_of(g.satellite);
    theirs.toe = of(g.toe);
    for (int a = 0; a < 3; ++a) {
      theirs.pos[a] = g.position_m[a];
      theirs.vel[a] = g.velocity_mps[a];
      theirs.acc[a] = g.acceleration_mps2[a];
    }
    theirs.taun = -g.clock_bias_s, theirs.gamn = g.clock_drift;
    for (const double dt : {-1799.5, -900.0, -61.3, 0.0, 59.9, 432.1, 1800.0}) {
      const Time<GpsClock> t = g.toe + from_seconds(dt);
      const SatelliteState ours = satellite_state(g, t);
      Eigen::Vector3d position;
      double clock = 0.0, variance = 0.0;
      geph2pos(of(t), &theirs, position.data(), &clock, &variance);
      EXPECT_LT((ours.position_ecef_m - position).norm(), 1e-3) << dt;
      EXPECT_LT(kC * std::abs(ours.clock_s - clock), 1e-6) << dt;
    }
  }
}

TEST(Rtklib, AtmosphereAndDirections) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  KlobucharModel model;
  model.alpha = {9.3132e-09, 1.4901e-08, -5.9605e-08, -1.1921e-07};
  model.beta = {8.8064e+04, 4.9152e+04, -1.3107e+05, -3.2768e+05};
  double ion[8];
  for (std::size_t i = 0; i < 4; ++i) ion[i] = model.alpha[i], ion[i + 4] = model.beta[i];
  for (int i = 0; i < 5000; ++i) {
    const Geodetic at{Angle::degrees(-89.0 + 178.0 * unit(random)),
                      Angle::degrees(-180.0 + 360.0 * unit(random)), 9000.0 * unit(random)};
    const double pos[] = {at.latitude.radians(), at.longitude.radians(), at.height_m};
    const LineOfSight sight{6.283 * unit(random), 0.01 + 1.56 * unit(random)};
    const double azel[] = {sight.azimuth_rad, sight.elevation_rad};
    const Time<GpsClock> t = gps_time(2000 + i % 300, from_seconds(604800.0 * unit(random)));
    EXPECT_NEAR(ionosphere_delay_m(model, t, at, sight, carrier::kL1),
                ionmodel(of(t), ion, pos, azel), 1e-6);
    // RTKLIB maps the zenith delay by 1 / sin of the elevation.
    EXPECT_NEAR(zenith_troposphere_delay_m(at, 0.7) / std::sin(sight.elevation_rad),
                tropmodel(of(t), pos, azel, 0.7), 1e-6);
  }
  // Black and Eisner's mapping against Niell's (1996): within 1 % down to 5°.
  const double middle[] = {0.8, 0.1, 100.0};
  for (double elevation = 0.0873; elevation < 1.57; elevation += 0.01) {
    const double azel[] = {0.0, elevation};
    const double niell = tropmapf(of(gps_time(2051, Duration(0))), middle, azel, nullptr);
    EXPECT_NEAR(troposphere_mapping(elevation) / niell, 1.0, 0.01) << elevation;
  }
  // Sagnac effect and direction, to satellites in all directions.
  for (int i = 0; i < 200; ++i) {
    const Geodetic at{Angle::degrees(-80.0 + 160.0 * unit(random)),
                      Angle::degrees(360.0 * unit(random) - 180.0), 100.0};
    const Eigen::Vector3d receiver = ecef_from_geodetic(at);
    const Eigen::Vector3d satellite =
        2.66e7 * (receiver.normalized() +
                  0.5 * Eigen::Vector3d(unit(random), unit(random), unit(random) - 0.5))
                     .normalized();
    double e[3], azel[2];
    const double distance = geodist(satellite.data(), receiver.data(), e);
    EXPECT_NEAR(distance - (satellite - receiver).norm(),
                wgs84::kEarthRate_radps / kC *
                    (satellite.x() * receiver.y() - satellite.y() * receiver.x()),
                1e-6);
    const double pos[] = {at.latitude.radians(), at.longitude.radians(), at.height_m};
    satazel(pos, e, azel);
    const LineOfSight sight = line_of_sight(at, satellite);
    EXPECT_NEAR(sight.elevation_rad, azel[1], 1e-8);
    EXPECT_NEAR(std::remainder(sight.azimuth_rad - azel[0], 2 * 3.14159265358979), 0.0, 1e-6);
  }
}

}  // namespace
}  // namespace wayfare
