#include <wayfare/sim/gnss.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace wayfare::sim {
namespace {

RangeParams perfect() {
  RangeParams params;
  params.range_sigma_m = params.range_rate_sigma_mps = 0.0;
  params.clock = {0.0, 0.0};
  params.clock_bias_m = params.clock_drift_mps = 0.0;
  return params;
}

TEST(Walker, OrbitsAsAFreeBody) {
  // In inertial axes the second difference is −μ p/|p|³; rates are those of the position.
  const Constellation gps = walker_constellation();
  ASSERT_EQ(gps.satellites.size(), 24U);
  const auto time = [](double s) { return Time<GpsClock>::from_seconds(1e9 + s); };
  const auto inertial = [&](SatelliteId id, double s) {
    const Eigen::Vector3d p = gps.motion(id, time(s))->position_ecef_m;
    return Eigen::Vector3d(
        Eigen::AngleAxisd(wgs84::kEarthRate_radps * s, Eigen::Vector3d::UnitZ()) * p);
  };
  for (const SatelliteId id : gps.satellites) {
    const double h = 10.0;
    const Eigen::Vector3d a = inertial(id, -h), b = inertial(id, 0), c = inertial(id, h);
    const Eigen::Vector3d gravity =
        -wgs84::kGravitationalConstant_m3ps2 / std::pow(b.norm(), 3) * b;
    EXPECT_LT(((a - 2 * b + c) / (h * h) - gravity).norm(), 1e-5);
    const SatelliteMotion m = *gps.motion(id, time(0));
    const Eigen::Vector3d slope =
        (gps.motion(id, time(0.5))->position_ecef_m - gps.motion(id, time(-0.5))->position_ecef_m);
    EXPECT_LT((slope - m.velocity_ecef_mps).norm(), 1e-3);
  }
  EXPECT_FALSE(gps.motion({GnssSystem::galileo, 3}, time(0)));
  EXPECT_FALSE(gps.motion({GnssSystem::gps, 25}, time(0)));
}

// Walker i: T/P/F: neighbours of a plane are 360°·P/T apart, planes 360°/P, and the satellite of
// the next plane is F·360°/T ahead of its neighbour.
TEST(Walker, SpreadsItsSatellitesEvenly) {
  const WalkerParams w{.satellites = 12, .planes = 3, .phasing = 2};
  const Constellation c = walker_constellation(w);
  const Time<GpsClock> t = Time<GpsClock>::from_seconds(0.0);
  const auto direction = [&](int plane, int slot) {
    const auto m = c.motion({w.system, static_cast<std::uint8_t>(1 + plane * 4 + slot)}, t);
    return Eigen::Vector3d(m->position_ecef_m / w.radius_m);
  };
  for (int plane = 0; plane < 3; ++plane) {
    const Eigen::Vector3d pole = direction(plane, 0).cross(direction(plane, 1));
    const double node = w.first_node.radians() + 2.0 * std::numbers::pi * plane / 3.0;
    EXPECT_NEAR(pole.z(), std::cos(w.inclination.radians()), 1e-12);
    EXPECT_NEAR(pole.dot(Eigen::Vector3d(std::cos(node), std::sin(node), 0.0)), 0.0, 1e-12);
    for (int slot = 0; slot < 4; ++slot) {
      EXPECT_NEAR(direction(plane, slot).dot(direction(plane, (slot + 1) % 4)), 0.0, 1e-12);
      // Height over the equator is proportional to the sine of the angle from the node.
      const double along = 2.0 * std::numbers::pi * (slot / 4.0 + 2.0 * plane / 12.0);
      EXPECT_NEAR(direction(plane, slot).z(), std::sin(w.inclination.radians()) * std::sin(along),
                  1e-12);
    }
  }
  EXPECT_FALSE(c.motion({GnssSystem::gps, 13}, t));
  EXPECT_FALSE(c.motion({GnssSystem::gps, 0}, t));
  EXPECT_FALSE(c.motion({GnssSystem::galileo, 1}, t));
  EXPECT_DEATH((void)walker_constellation({.satellites = 10, .planes = 3}), "same number");
}

TEST(Walker, CombinesTwoSystems) {
  const Constellation both = gps_and_galileo();
  const std::set<SatelliteId> named(both.satellites.begin(), both.satellites.end());
  EXPECT_EQ(named.size(), 48U);
  const Time<GpsClock> t = Time<GpsClock>::from_seconds(1e9);
  for (const SatelliteId id : both.satellites) {
    const auto m = both.motion(id, t);
    ASSERT_TRUE(m);
    EXPECT_NEAR(m->position_ecef_m.norm(), id.system == GnssSystem::gps ? 26'559'710 : 29'600'318,
                1e-3);
  }
  EXPECT_FALSE(both.motion({GnssSystem::beidou, 1}, t));
  EXPECT_FALSE(seen_from(both, {GnssSystem::beidou, 1}, t, Eigen::Vector3d(6.4e6, 0, 0)));
}

TEST(SeenFrom, IsLightTimeAndEarthRotationEarlier) {
  // In inertial axes that coincide with Earth-fixed ones at reception, the signal travels straight
  // at the speed of light from the satellite's position at transmission.
  const Constellation gps = walker_constellation();
  const Geodetic place{Angle::degrees(51.0), Angle::degrees(-114.0), 1000.0};
  const Eigen::Vector3d receiver = ecef_from_geodetic(place);
  const auto now = Time<GpsClock>::from_seconds(5e8);
  for (const SatelliteId id : gps.satellites) {
    const SatelliteMotion seen = *seen_from(gps, id, now, receiver);
    const double travel = (seen.position_ecef_m - receiver).norm() / 299792458.0;
    const SatelliteMotion then = *gps.motion(id, now - from_seconds(travel));
    EXPECT_NEAR(seen.position_ecef_m.norm(), then.position_ecef_m.norm(), 1e-6);
    EXPECT_NEAR(seen.position_ecef_m.z(), then.position_ecef_m.z(), 1e-4);
    // Sagnac's effect to first order: ω/c (x_s y_r − y_s x_r) (Groves 2013, (9.113)).
    const double plain = (then.position_ecef_m - receiver).norm();
    const double sagnac =
        wgs84::kEarthRate_radps / 299792458.0 *
        (then.position_ecef_m.x() * receiver.y() - then.position_ecef_m.y() * receiver.x());
    EXPECT_NEAR(travel * 299792458.0 - plain, sagnac, 1e-3);
  }
}

TEST(SimulateRanges, AreTheDistanceAndItsDerivative) {
  const VehicleTrajectory drive = demo_drive();
  RangeParams params = perfect();
  params.period = from_seconds(0.01);
  params.antenna_lever_arm_m = {0.5, -0.2, -1.4};
  const Constellation sky = gps_and_galileo();
  const SimulatedRanges ranges = simulate_ranges(drive, sky, params, Rng(1));
  const std::size_t k = 4000;  // 40 s: under way
  for (std::size_t i = 0; i < ranges.epochs[k].satellites.size(); ++i) {
    const CorrectedRange &a = ranges.epochs[k - 1].satellites[i],
                         &b = ranges.epochs[k].satellites[i],
                         &c = ranges.epochs[k + 1].satellites[i];
    ASSERT_EQ(a.satellite, c.satellite);
    const Eigen::Vector3d antenna =
        ecef_motion(drive.motion(ranges.epochs[k].time), params.antenna_lever_arm_m).position_m;
    EXPECT_NEAR(b.range_m, (b.position_ecef_m - antenna).norm(), 1e-6);
    // The satellite's motion is given at transmission; the range's true derivative is smaller by a
    // share ṙ/c, and Earth-fixed axes of reception rotate meanwhile: some millimetres per second.
    EXPECT_NEAR((c.range_m - a.range_m) / 0.02, b.range_rate_mps, 0.02);
  }
}

TEST(SimulateRanges, ContainSatellitesAboveTheMask) {
  const VehicleTrajectory drive = demo_drive();
  RangeParams params = perfect();
  const auto all = simulate_ranges(drive, gps_and_galileo(), params, Rng(1));
  for (const RangeEpoch& epoch : all.epochs) {
    EXPECT_GE(epoch.satellites.size(), 11U);
    for (const CorrectedRange& r : epoch.satellites)
      EXPECT_GE(elevation(drive.state(epoch.time).position, r.position_ecef_m).degrees(), 10.0);
  }
  EXPECT_EQ(all.epochs.size(), 311U);
  params.elevation_mask = Angle::degrees(90.0);
  for (const RangeEpoch& epoch : simulate_ranges(drive, gps_and_galileo(), params, Rng(1)).epochs)
    EXPECT_TRUE(epoch.satellites.empty());
}

TEST(SimulateRanges, AnOutageRemovesSatellitesAndDoesNotChangeTheRest) {
  const VehicleTrajectory drive = demo_drive();
  RangeParams params;
  params.max_satellites = 8;
  const auto whole = simulate_ranges(drive, gps_and_galileo(), params, Rng(4));
  params.outages = {{LogTime::from_seconds(100), LogTime::from_seconds(130), 3}};
  const auto cut = simulate_ranges(drive, gps_and_galileo(), params, Rng(4));
  ASSERT_EQ(whole.epochs.size(), cut.epochs.size());
  for (std::size_t k = 0; k < cut.epochs.size(); ++k) {
    const bool within = k >= 100 && k < 130;
    EXPECT_EQ(cut.epochs[k].satellites.size(), within ? 3U : 8U);
    for (const CorrectedRange& r : cut.epochs[k].satellites) {
      bool same = false;
      for (const CorrectedRange& w : whole.epochs[k].satellites)
        same = same || (w.satellite == r.satellite && w.range_m == r.range_m);
      EXPECT_TRUE(same);
    }
  }
}

TEST(SimulateRanges, HaveTheConfiguredErrors) {
  const VehicleTrajectory drive = demo_drive();
  RangeParams exact = perfect(), params;
  params.clock = {0.0, 0.0};
  params.clock_bias_m = params.clock_drift_mps = 0.0;
  params.period = exact.period = from_seconds(0.2);
  const auto truth = simulate_ranges(drive, gps_and_galileo(), exact, Rng(4));
  const auto noisy = simulate_ranges(drive, gps_and_galileo(), params, Rng(4));
  double range = 0, rate = 0, product = 0, mean = 0, n = 0;
  for (std::size_t k = 0; k < truth.epochs.size(); ++k) {
    for (std::size_t i = 0; i < truth.epochs[k].satellites.size(); ++i) {
      const double r =
          (noisy.epochs[k].satellites[i].range_m - truth.epochs[k].satellites[i].range_m) /
          params.range_sigma_m;
      const double d = (noisy.epochs[k].satellites[i].range_rate_mps -
                        truth.epochs[k].satellites[i].range_rate_mps) /
                       params.range_rate_sigma_mps;
      range += r * r, rate += d * d, product += r * d, mean += r, n += 1;
    }
  }
  const double five = 5.0 * std::sqrt(2.0 / n);
  EXPECT_NEAR(range / n, 1.0, five);
  EXPECT_NEAR(rate / n, 1.0, five);
  EXPECT_NEAR(product / n, 0.0, five);
  EXPECT_NEAR(mean / n, 0.0, five);
}

TEST(SimulateRanges, MultipathLengthensRangesOccasionally) {
  const VehicleTrajectory drive = demo_drive();
  RangeParams params = perfect();
  const auto truth = simulate_ranges(drive, gps_and_galileo(), params, Rng(4));
  params.multipath.per_satellite_hour = 60.0;
  const auto burst = simulate_ranges(drive, gps_and_galileo(), params, Rng(4));
  double hit = 0, n = 0, sum = 0;
  for (std::size_t k = 0; k < truth.epochs.size(); ++k) {
    for (std::size_t i = 0; i < truth.epochs[k].satellites.size(); ++i) {
      const double excess =
          burst.epochs[k].satellites[i].range_m - truth.epochs[k].satellites[i].range_m;
      EXPECT_GE(excess, -1e-6);
      n += 1;
      if (excess > 1e-6) hit += 1, sum += excess;
    }
  }
  // A burst a minute of 10 s on average, rounded up to whole seconds: about a sixth of the time.
  EXPECT_NEAR(hit / n, 10.5 / 70.5, 0.05);
  EXPECT_NEAR(sum / hit, params.multipath.mean_excess_m, 8.0);
}

TEST(StepClock, SpreadsAsTwoRandomWalks) {
  // Var drift q_d T; var bias q_b T + q_d T³/3; covariance q_d T²/2, for any step.
  const ReceiverClockNoise noise{0.3, 0.1};
  double bias = 0, drift = 0, both = 0;
  const int runs = 20000;
  Rng rng(2);
  for (int run = 0; run < runs; ++run) {
    ReceiverClock c{0.0, 0.0};
    for (const double step : {0.5, 3.0, 6.5}) c = step_clock(c, noise, step, rng);
    bias += c.bias_m * c.bias_m / runs, drift += c.drift_mps * c.drift_mps / runs;
    both += c.bias_m * c.drift_mps / runs;
  }
  const double qb = 0.09, qd = 0.01, t = 10.0, five = 5.0 * std::sqrt(2.0 / runs);
  EXPECT_NEAR(bias / (qb * t + qd * t * t * t / 3), 1.0, five);
  EXPECT_NEAR(drift / (qd * t), 1.0, five);
  EXPECT_NEAR(both / (qd * t * t / 2), 1.0, 1.5 * five);
}

TEST(BestGeometry, SelectsASpreadAndIsNested) {
  std::vector<Eigen::Vector3d> directions;
  const auto towards = [](double azimuth, double up) {
    const double a = Angle::degrees(azimuth).radians(), e = Angle::degrees(up).radians();
    return Eigen::Vector3d(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), -std::sin(e));
  };
  for (const double azimuth : {0.0, 2.0, 4.0, 6.0, 120.0, 240.0})
    directions.push_back(towards(azimuth, 10.0));
  directions.push_back(towards(0.0, 90.0));
  // One of the four neighbours in the north, the two others around, the zenith.
  const auto four = best_geometry(directions, 4);
  ASSERT_EQ(four.size(), 4U);
  EXPECT_LE(four[0], 3U);
  EXPECT_EQ(four[1], 4U);
  EXPECT_EQ(four[2], 5U);
  EXPECT_EQ(four[3], 6U);
  for (std::size_t n = 1; n < 8; ++n) {
    const auto less = best_geometry(directions, n - 1), more = best_geometry(directions, n);
    EXPECT_TRUE(std::includes(more.begin(), more.end(), less.begin(), less.end()));
  }
  EXPECT_EQ(best_geometry(directions, 99).size(), directions.size());
}

}  // namespace
}  // namespace wayfare::sim
