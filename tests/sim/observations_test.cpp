#include <wayfare/sim/gnss.hpp>

#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/gnss/single_point.hpp>

namespace wayfare::sim {
namespace {

const LogTime kStart = LogTime::from_seconds(1.4e9);

Ephemerides sky() {
  WalkerParams galileo;
  galileo.system = GnssSystem::galileo;
  galileo.planes = 3;
  galileo.radius_m = 29'600'318.0;
  const auto reference = gps_time(kStart + std::chrono::minutes(3));
  Ephemerides all = walker_ephemerides({}, reference);
  all.add(walker_ephemerides(galileo, reference));
  all.gps_ionosphere = nominal_ionosphere();
  return all;
}

ObservationParams exact() {
  ObservationParams p;
  p.code_sigma_m = p.doppler_sigma_hz = 0.0;
  p.period = std::chrono::seconds(10);
  return p;
}

TEST(SimulateObservations, ASinglePointSolutionFindsTheReceiverAndItsClock) {
  // Simulation and correction share the models of atmosphere and orbits, but have separate code for
  // light time, Earth rotation, clocks and group delay.
  const VehicleTrajectory drive = demo_drive(kStart);
  const Ephemerides messages = sky();
  const SimulatedObservations simulated = simulate_observations(drive, messages, exact(), Rng(1));
  for (std::size_t k = 0; k < simulated.epochs.size(); ++k) {
    EXPECT_GE(simulated.epochs[k].satellites.size(), 9U);
    const double bias = simulated.clocks[k].bias_m;
    const NavState truth =
        drive.state(log_time(simulated.epochs[k].time) - from_seconds(bias / 299792458.0));
    // The position is given, so that the atmosphere is that of the position itself.
    const auto point =
        single_point(simulated.epochs[k], messages, {}, ecef_from_geodetic(truth.position));
    ASSERT_TRUE(point) << point.error().to_string();
    EXPECT_LT(ned_from_geodetic(point->position, truth.position).norm(), 2e-3);
    EXPECT_NEAR(point->clock_bias_m[0], bias, 2e-3);
    ASSERT_TRUE(point->velocity_ned_mps);
    EXPECT_LT((*point->velocity_ned_mps - truth.velocity_ned_mps).norm(), 2e-3);
    EXPECT_NEAR(point->clock_drift_mps, simulated.clocks[k].drift_mps, 2e-3);
  }
}

TEST(SimulateObservations, TheAtmosphereLengthensRanges) {
  const VehicleTrajectory drive = demo_drive(kStart);
  const Ephemerides messages = sky();
  ObservationParams none = exact();
  none.ionosphere = none.troposphere = false;
  const auto with = simulate_observations(drive, messages, exact(), Rng(1));
  const auto without = simulate_observations(drive, messages, none, Rng(1));
  for (std::size_t i = 0; i < with.epochs[3].satellites.size(); ++i) {
    const double delay =
        with.epochs[3].satellites[i].pseudorange_m - without.epochs[3].satellites[i].pseudorange_m;
    EXPECT_GT(delay, 2.0);   // at 1.1 km the troposphere's zenith delay is about 2.1 m
    EXPECT_LT(delay, 40.0);  // ten times that plus the ionosphere near 10° of elevation
  }
}

TEST(SimulateObservations, NoiseIsAsConfigured) {
  const VehicleTrajectory drive = demo_drive(kStart);
  const Ephemerides messages = sky();
  ObservationParams noisy = exact(), clean = exact();
  noisy.period = clean.period = std::chrono::seconds(1);
  noisy.code_sigma_m = 0.6, noisy.doppler_sigma_hz = 0.3;
  const auto a = simulate_observations(drive, messages, clean, Rng(1));
  const auto b = simulate_observations(drive, messages, noisy, Rng(1));
  double code = 0, doppler = 0, n = 0;
  for (std::size_t k = 0; k < a.epochs.size(); ++k)
    for (std::size_t i = 0; i < a.epochs[k].satellites.size(); ++i) {
      const auto &x = a.epochs[k].satellites[i], &y = b.epochs[k].satellites[i];
      code += std::pow((y.pseudorange_m - x.pseudorange_m) / 0.6, 2);
      doppler += std::pow((y.doppler_hz - x.doppler_hz) / 0.3, 2);
      n += 1;
    }
  EXPECT_NEAR(code / n, 1.0, 5 * std::sqrt(2 / n));
  EXPECT_NEAR(doppler / n, 1.0, 5 * std::sqrt(2 / n));
}

TEST(BroadcastConstellation, GivesRangesToo) {
  const VehicleTrajectory drive = demo_drive(kStart);
  const Ephemerides messages = sky();
  RangeParams params;
  const auto ranges = simulate_ranges(drive, broadcast_constellation(messages), params, Rng(1));
  const auto point = single_point(ranges.epochs[100]);
  ASSERT_TRUE(point) << point.error().to_string();
  const Geodetic truth = drive.state(ranges.epochs[100].time).position;
  EXPECT_LT(ned_from_geodetic(point->position, truth).norm(), 10.0);  // 2 m times dilution
}

}  // namespace
}  // namespace wayfare::sim
