// Laws of orbits and clocks; rtklib_test.cpp compares positions with RTKLIB.

#include <wayfare/gnss/ephemerides.hpp>

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <wayfare/gnss/gps_time.hpp>

namespace wayfare {
namespace {

using Eigen::Vector3d;
using std::chrono::hours;
using std::chrono::seconds;

constexpr double kMu = 3.9860050e14, kEarthRate = 7.2921151467e-5;  // IS-GPS-200

/// No corrections; `toe` is in the middle of a week.
KeplerianEphemeris plain(double eccentricity = 0.0) {
  KeplerianEphemeris k;
  k.satellite = {GnssSystem::gps, 7};
  k.toe = k.toc = gps_time(2100, hours(80));
  k.sqrt_semi_major_axis = 5153.7;
  k.eccentricity = eccentricity;
  k.inclination_rad = 0.96;
  k.ascending_node_rad = 1.2;
  k.mean_anomaly_rad = -0.4;
  k.argument_of_perigee_rad = 0.7;
  return k;
}

KeplerianEphemeris with_everything(GnssSystem system, int number) {
  KeplerianEphemeris k = plain(0.012);
  k.satellite = {system, static_cast<std::uint8_t>(number)};
  k.mean_motion_difference_radps = 4.5e-9;
  k.inclination_rate_radps = -3e-10;
  k.ascending_node_rate_radps = -8e-9;
  k.cuc_rad = 1.5e-6, k.cus_rad = 8e-6;
  k.crc_m = 210.0, k.crs_m = 30.0;
  k.cic_rad = -1e-7, k.cis_rad = 6e-8;
  k.clock_bias_s = 2e-4, k.clock_drift = -3e-12, k.clock_drift_rate_per_s = 1e-18;
  return k;
}

/// In inertial axes that coincide with the Earth's at the start of the week.
Vector3d inertial(const Vector3d& ecef, Time<GpsClock> t) {
  return Eigen::AngleAxisd(kEarthRate * to_seconds(week_time(t).of_week), Vector3d::UnitZ()) * ecef;
}

// Kepler's laws on a message without corrections: an ellipse about the Earth's centre, its period
// 2π√(a³/μ), equal areas in equal times; the accelerations follow from the second differences.
TEST(KeplerianEphemeris, ObeysKeplersLaws) {
  for (const double e : {0.0, 0.02, 0.3}) {
    const KeplerianEphemeris k = plain(e);
    const double a = 5153.7 * 5153.7, root = std::sqrt(kMu * a * (1.0 - e * e));
    const auto at = [&](double s) {
      const Time<GpsClock> t = k.toe + from_seconds(s);
      return inertial(satellite_state(k, t).position_ecef_m, t);
    };
    for (double s = -7000.0; s <= 7000.0; s += 1000.0) {
      const Vector3d p = at(s), before = at(s - 1.0), after = at(s + 1.0);
      const Vector3d acceleration = after - 2.0 * p + before;
      EXPECT_LT((acceleration + kMu / std::pow(p.norm(), 3) * p).norm(), 1e-6);  // 1e-8 m rounding
      const Time<GpsClock> t = k.toe + from_seconds(s);
      const SatelliteState state = satellite_state(k, t);
      const Vector3d turning = Vector3d(0, 0, kEarthRate).cross(state.position_ecef_m);
      const Vector3d velocity = inertial(state.velocity_ecef_mps + turning, t);
      EXPECT_NEAR(p.cross(velocity).norm() / root, 1.0, 1e-13);
      EXPECT_LE(p.norm(), a * (1.0 + e) + 1e-6);
      EXPECT_GE(p.norm(), a * (1.0 - e) - 1e-6);
    }
    const double period = 2.0 * std::numbers::pi * std::sqrt(a * a * a / kMu);
    EXPECT_LT((at(0.5 * period) - at(-0.5 * period)).norm(), 1e-4);  // of nanoseconds of time
  }
}

// At perigee, reference time and node: a (1 − e) along the node.
TEST(KeplerianEphemeris, PositionAtTheNodeMatchesTheElements) {
  KeplerianEphemeris k = plain(0.1);
  k.mean_anomaly_rad = k.argument_of_perigee_rad = 0.0;
  const double a = 5153.7 * 5153.7;
  const double node = k.ascending_node_rad - kEarthRate * 80.0 * 3600.0;
  const Vector3d want = 0.9 * a * Vector3d(std::cos(node), std::sin(node), 0.0);
  EXPECT_LT((satellite_state(k, k.toe).position_ecef_m - want).norm(), 1e-6);
  k.crc_m = 100.0;   // cos 0
  k.crs_m = 1000.0;  // sin 0
  EXPECT_LT((satellite_state(k, k.toe).position_ecef_m - want * (1.0 + 100.0 / (0.9 * a))).norm(),
            1e-6);
}

TEST(KeplerianEphemeris, VelocityAndDriftAreTheDerivatives) {
  for (const auto& [system, number] : {std::pair{GnssSystem::gps, 3},
                                       {GnssSystem::galileo, 3},
                                       {GnssSystem::beidou, 30},
                                       {GnssSystem::beidou, 3}}) {  // the last is geostationary
    const KeplerianEphemeris k = with_everything(system, number);
    for (double s = -6000.0; s <= 6000.0; s += 1500.0) {
      const auto at = [&](double by) { return satellite_state(k, k.toe + from_seconds(s + by)); };
      const Vector3d velocity = (at(0.5).position_ecef_m - at(-0.5).position_ecef_m);
      // Error: a 24th of the third derivative, a ω³ = 8e-5 m/s³.
      EXPECT_LT((velocity - at(0).velocity_ecef_mps).norm(), 1e-5) << to_string(k.satellite);
      EXPECT_NEAR((at(50).clock_s - at(-50).clock_s) / 100.0, at(0).clock_drift, 1e-15);
    }
  }
}

// Relativity of an eccentric orbit: F e √A sin E is −2 r·v/c² (IS-GPS-200 20.3.3.3.3.1).
TEST(KeplerianEphemeris, ClockIsItsPolynomialAndRelativity) {
  KeplerianEphemeris k = plain(0.02);
  k.toc = k.toe - seconds(600);
  k.clock_bias_s = 1e-4, k.clock_drift = 1e-11, k.clock_drift_rate_per_s = 1e-17;
  for (const double s : {-7000.0, 0.0, 3000.0}) {
    const Time<GpsClock> t = k.toe + from_seconds(s);
    const SatelliteState state = satellite_state(k, t);
    const Vector3d v =
        state.velocity_ecef_mps + Vector3d(0, 0, kEarthRate).cross(state.position_ecef_m);
    const double since = s + 600.0;
    const double want =
        1e-4 + 1e-11 * since + 1e-17 * since * since -
        2.0 * state.position_ecef_m.dot(v) / (kSpeedOfLight_mps * kSpeedOfLight_mps);
    EXPECT_NEAR(state.clock_s, want, 1e-15);
  }
}

// Ω₀ refers to the start of the week: messages on either side of a week boundary describe one orbit
// if the node is shifted by the Earth's rotation.
TEST(KeplerianEphemeris, IsContinuousAcrossTheEndOfTheWeek) {
  KeplerianEphemeris before = plain(0.01);
  before.toe = before.toc = gps_time(2100, hours(7 * 24) - seconds(1800));
  KeplerianEphemeris after = before;
  after.toe = after.toc = gps_time(2101, seconds(1800));
  const double a = 5153.7 * 5153.7, motion = std::sqrt(kMu / (a * a * a));
  after.mean_anomaly_rad += motion * 3600.0;
  after.ascending_node_rad -= kEarthRate * 7.0 * 86400.0;
  for (const double s : {-3600.0, 0.0, 3600.0}) {
    const Time<GpsClock> t = gps_time(2101, from_seconds(s));
    const SatelliteState x = satellite_state(before, t), y = satellite_state(after, t);
    EXPECT_LT((x.position_ecef_m - y.position_ecef_m).norm(), 1e-5);
    EXPECT_LT((x.velocity_ecef_mps - y.velocity_ecef_mps).norm(), 1e-9);
  }
}

GlonassEphemeris glonass() {
  GlonassEphemeris g;
  g.satellite = {GnssSystem::glonass, 4};
  g.toe = gps_time(2100, hours(80));
  g.position_m = {7.0e6, -1.2e7, 2.138e7};
  g.velocity_mps = {1500.0, 2500.0, 912.0};
  g.acceleration_mps2 = {1e-6, -2e-6, 1e-6};
  g.clock_bias_s = 3e-5, g.clock_drift = 1e-12;
  return g;
}

TEST(GlonassEphemeris, IsReversibleAndConvergesToFourthOrder) {
  const GlonassEphemeris g = glonass();
  const SatelliteState there = satellite_state(g, g.toe + seconds(900));
  GlonassEphemeris back = g;
  back.toe = g.toe + seconds(900);
  back.position_m = there.position_ecef_m, back.velocity_mps = there.velocity_ecef_mps;
  // The state is quantised to 2⁻¹¹ km, 0.49 m: a hundredth of that is negligible.
  EXPECT_LT((satellite_state(back, g.toe).position_ecef_m - g.position_m).norm(), 4.9e-3);
  EXPECT_EQ(satellite_state(g, g.toe).position_ecef_m, g.position_m);
  const auto error_m = [&](double step_s, int after_s) {
    const auto at = g.toe + seconds(after_s);
    return (satellite_state(g, at, step_s).position_ecef_m -
            satellite_state(g, at, 10.0).position_ecef_m)
        .norm();
  };
  EXPECT_NEAR(std::log2(error_m(1200, 7200) / error_m(600, 7200)), 4.0, 0.6);
  EXPECT_LT(error_m(60, 1800), 4.9e-3);
  EXPECT_NEAR(there.clock_s, 3e-5 + 900e-12, 1e-18);
}

// Without Sun and Moon v²/2 − μ/r (1 − J₂ …) − ω²(x² + y²)/2 is Jacobi's constant.
TEST(GlonassEphemeris, KeepsJacobisConstant) {
  GlonassEphemeris g = glonass();
  g.acceleration_mps2.setZero();
  const auto constant = [](const Vector3d& p, const Vector3d& v) {
    constexpr double kGlonassMu = 3.9860044e14, kJ2 = 1.0826257e-3, kRadius = 6378136.0;
    constexpr double kRate = 7.292115e-5;
    const double r = p.norm(), sine = p.z() / r;
    const double flattening =
        1.0 - kJ2 * (kRadius / r) * (kRadius / r) * 0.5 * (3.0 * sine * sine - 1.0);
    return 0.5 * v.squaredNorm() - kGlonassMu / r * flattening -
           0.5 * kRate * kRate * p.head<2>().squaredNorm();
  };
  const double start = constant(g.position_m, g.velocity_mps);
  for (const int s : {900, -900, 7200}) {
    const SatelliteState x = satellite_state(g, g.toe + seconds(s));
    // Steps of a minute leave millimetres of 25 000 km; without J₂ the change is 1e-5.
    EXPECT_NEAR(constant(x.position_ecef_m, x.velocity_ecef_mps) / start, 1.0, 1e-9);
  }
}

TEST(GroupDelay, DependsOnTheSignal) {
  KeplerianEphemeris k = plain();
  k.group_delay_s[0] = 4e-9, k.group_delay_s[1] = -6e-9;
  const double gamma = std::pow(carrier::kL1 / carrier::kL2, 2);
  EXPECT_DOUBLE_EQ(*group_delay_s(k, carrier::kL1), 4e-9);
  EXPECT_DOUBLE_EQ(*group_delay_s(k, carrier::kL2), gamma * 4e-9);
  EXPECT_FALSE(group_delay_s(k, carrier::kL5));  // broadcast in CNAV messages only
  k.satellite.system = GnssSystem::galileo;
  EXPECT_DOUBLE_EQ(*group_delay_s(k, carrier::kE1), -6e-9);
  k.clock_of_e5a = true;
  EXPECT_DOUBLE_EQ(*group_delay_s(k, carrier::kE1), 4e-9);
  EXPECT_DOUBLE_EQ(*group_delay_s(k, carrier::kE5a),
                   4e-9 * std::pow(carrier::kE1 / carrier::kE5a, 2));
  EXPECT_FALSE(group_delay_s(k, carrier::kE6));
  k.satellite.system = GnssSystem::beidou;
  EXPECT_DOUBLE_EQ(*group_delay_s(k, carrier::kB1I), 4e-9);
  EXPECT_DOUBLE_EQ(*group_delay_s(k, carrier::kB2I), -6e-9);
  EXPECT_DOUBLE_EQ(*group_delay_s(k, carrier::kB3I), 0.0);
  EXPECT_FALSE(group_delay_s(k, carrier::kB1C));
  GlonassEphemeris g = glonass();
  g.l2_minus_l1_s = 7e-9;
  EXPECT_EQ(group_delay_s(g, 1602e6), 0.0);
  EXPECT_EQ(group_delay_s(g, 1246e6), 7e-9);
}

// RINEX 3.04 table A8 for Galileo: E1-B in bits 0-2, E5a in 3-5, E5b in 6-8.
TEST(Health, UsesTheBitsOfTheSignal) {
  KeplerianEphemeris k = plain();
  EXPECT_TRUE(is_healthy(k, carrier::kL1));
  k.health = 63;
  EXPECT_FALSE(is_healthy(k, carrier::kL1));
  k.satellite.system = GnssSystem::galileo;
  const double carriers[] = {carrier::kE1, carrier::kE5a, carrier::kE5b};
  for (int signal = 0; signal < 3; ++signal)
    for (int bit = 0; bit < 3; ++bit) {
      k.health = 1 << (3 * signal + bit);
      for (int other = 0; other < 3; ++other)
        EXPECT_EQ(is_healthy(k, carriers[other]), other != signal) << k.health;
    }
  GlonassEphemeris g = glonass();
  EXPECT_TRUE(is_healthy(g, 1602e6));
  g.health = 4;
  EXPECT_FALSE(is_healthy(g, 1602e6));
}

TEST(Beidou, GeostationarySatellitesAreStationary) {
  EXPECT_TRUE(is_beidou_geostationary({GnssSystem::beidou, 5}));
  EXPECT_FALSE(is_beidou_geostationary({GnssSystem::beidou, 6}));
  EXPECT_TRUE(is_beidou_geostationary({GnssSystem::beidou, 59}));
  EXPECT_FALSE(is_beidou_geostationary({GnssSystem::gps, 3}));
  // A circle of one sidereal day, with the opposite tilt to that of the frame: it lies in the
  // equator.
  KeplerianEphemeris k = plain();
  k.satellite = {GnssSystem::beidou, 3};
  constexpr double kRate = 7.2921150e-5;
  k.sqrt_semi_major_axis = std::pow(3.986004418e14 / (kRate * kRate), 1.0 / 6.0);
  k.inclination_rad = 5.0 * std::numbers::pi / 180.0;
  k.ascending_node_rad =
      std::numbers::pi + kRate * to_seconds(week_time(k.toe - kGpsMinusBeidou).of_week);
  const Vector3d start = satellite_state(k, k.toe).position_ecef_m;
  EXPECT_NEAR(start.z(), 0.0, 1.0);
  for (const int h : {-6, -1, 3, 12}) {
    const SatelliteState x = satellite_state(k, k.toe + hours(h));
    EXPECT_LT((x.position_ecef_m - start).norm(), 1.0);
    EXPECT_LT(x.velocity_ecef_mps.norm(), 1e-3);
  }
}

}  // namespace
}  // namespace wayfare
