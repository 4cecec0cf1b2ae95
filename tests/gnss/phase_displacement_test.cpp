// Displacement from carrier phases, and cycle slips.

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/gnss/phase_displacement.hpp>

namespace wayfare {
namespace {

using Eigen::Vector3d;

const Geodetic kHere{Angle::degrees(48.7), Angle::degrees(9.1), 300.0};
const Vector3d kMoved(12.0, -9.0, 4.0);  // in Earth-fixed axes, in a second
constexpr double kClock_m = 57.0, kCycle_m = 0.19029367;

/// Eight satellites over the sky; phases of an antenna that moves, with a constant each.
RangeEpoch epoch_of(int second, double noise_m, std::uint64_t seed) {
  Rng rng = Rng(seed).stream(static_cast<std::uint64_t>(second));
  RangeEpoch epoch{LogTime::from_seconds(1000.0 + second), {}};
  const Vector3d antenna = ecef_from_geodetic(kHere) + second * kMoved;
  for (int i = 0; i < 8; ++i) {
    const double azimuth = 0.8 * i, elevation = 0.25 + 0.15 * i;
    const Vector3d ned(std::cos(azimuth) * std::cos(elevation),
                       std::sin(azimuth) * std::cos(elevation), -std::sin(elevation));
    CorrectedRange s;
    s.satellite = {GnssSystem::gps, static_cast<std::uint8_t>(i + 1)};
    s.velocity_ecef_mps = Vector3d(1000.0 - 300.0 * i, 2000.0, -800.0 + 200.0 * i);
    s.position_ecef_m = ecef_from_geodetic(kHere) + 2.2e7 * (rotation_ecef_ned(kHere) * ned) +
                        second * s.velocity_ecef_mps;
    const Vector3d line = s.position_ecef_m - antenna;
    s.phase_m = line.norm() + second * kClock_m + 1000.0 * i + noise_m * rng.normal();
    s.phase_sigma_m = 0.003;
    s.range_rate_mps = line.normalized().dot(s.velocity_ecef_mps - kMoved) + kClock_m;
    epoch.satellites.push_back(s);
  }
  return epoch;
}

TEST(PhaseDisplacement, IsTheMotionOfTheAntenna) {
  const RangeEpoch a = epoch_of(0, 0.0, 1), b = epoch_of(1, 0.0, 1);
  const auto d = phase_displacement(a, b, ecef_from_geodetic(kHere));
  ASSERT_TRUE(d);
  EXPECT_LT((d->displacement_ecef_m - kMoved).norm(), 1e-6);
  EXPECT_NEAR(d->clock_m, kClock_m, 1e-6);
  EXPECT_EQ(d->used.size(), 8U);
  // An error of the position of 10 m is one of some millimetres: satellites move by 4 km/s.
  const auto off = phase_displacement(a, b, ecef_from_geodetic(kHere) + Vector3d(6.0, 8.0, 0.0));
  EXPECT_LT((off->displacement_ecef_m - kMoved).norm(), 0.01);
}

// χ² of four degrees of freedom: mean 4, standard deviation √(8/200) of the mean.
TEST(PhaseDisplacement, ErrorsMatchTheCovariance) {
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const auto d = phase_displacement(epoch_of(0, 0.003, seed), epoch_of(1, 0.003, seed),
                                      ecef_from_geodetic(kHere), 10.0);
    ASSERT_TRUE(d);
    Eigen::Vector4d error;
    error << d->displacement_ecef_m - kMoved, d->clock_m - kClock_m;
    sum += error.dot(d->covariance.llt().solve(error));
  }
  EXPECT_NEAR(sum / 200.0, 4.0, 4.0 * std::sqrt(8.0 / 200.0));
}

TEST(PhaseDisplacement, FindsCycleSlips) {
  std::size_t found = 0, wrong = 0;
  for (std::uint64_t seed = 1; seed <= 80; ++seed) {
    RangeEpoch b = epoch_of(1, 0.003, seed);
    const std::size_t which = seed % 8, other = (seed + 3) % 8;
    b.satellites[which].phase_m += (seed % 2 == 0 ? 1.0 : -2.0) * kCycle_m;
    if (seed % 4 == 0) b.satellites[other].phase_m += 30.0 * kCycle_m;
    const auto d = phase_displacement(epoch_of(0, 0.003, seed), b, ecef_from_geodetic(kHere));
    ASSERT_TRUE(d);
    const auto slipped = [&](std::size_t i) {
      return std::count(d->slipped.begin(), d->slipped.end(), b.satellites[i].satellite) == 1;
    };
    const bool all = slipped(which) && (seed % 4 != 0 || slipped(other));
    found += all ? 1 : 0;
    wrong += d->slipped.size() > (seed % 4 == 0 ? 2U : 1U) ? 1 : 0;
    if (all) {
      EXPECT_LT((d->displacement_ecef_m - kMoved).norm(), 0.05) << seed;
    }
  }
  // One cycle is 45 σ of a pair. None is missed; a good satellite falls out of 4 σ once in 16 000.
  EXPECT_EQ(found, 80U);
  EXPECT_LE(wrong, 2U);
}

TEST(PhaseDisplacement, ASlipAmongFiveSatellitesIsNotAttributed) {
  RangeEpoch a = epoch_of(0, 0.0, 1), b = epoch_of(1, 0.0, 1);
  a.satellites.resize(5), b.satellites.resize(5);
  for (auto* e : {&a, &b})
    for (CorrectedRange& s : e->satellites) s.range_rate_mps = std::nan("");
  EXPECT_TRUE(phase_displacement(a, b, ecef_from_geodetic(kHere)));
  b.satellites[2].phase_m += kCycle_m;
  EXPECT_FALSE(phase_displacement(a, b, ecef_from_geodetic(kHere)));
}

TEST(PhaseDisplacement, RatesTellSlipsWithoutRedundancy) {
  RangeEpoch a = epoch_of(0, 0.003, 1), b = epoch_of(1, 0.003, 1);
  b.satellites[5].phase_m += 50.0 * kCycle_m;
  std::vector<PhasePair> pairs = phase_pairs(a, b);
  ASSERT_EQ(pairs.size(), 8U);
  EXPECT_EQ(drop_slips_by_rates(pairs, 1.0, 0.3, ecef_from_geodetic(kHere)), std::vector{b.satellites[5].satellite});
  EXPECT_EQ(pairs.size(), 7U);
}

TEST(PhaseDisplacement, RefusesWhatDoesNotFit) {
  const RangeEpoch a = epoch_of(0, 0.0, 1), b = epoch_of(1, 0.0, 1);
  const Vector3d here = ecef_from_geodetic(kHere);
  EXPECT_FALSE(phase_displacement(b, a, here));  // backwards in time
  EXPECT_FALSE(phase_displacement(a, a, here));
  EXPECT_FALSE(phase_displacement({}, b, here));
  EXPECT_FALSE(phase_displacement(a, b, Vector3d(std::nan(""), 0.0, 0.0)));
  RangeEpoch few = b;
  few.satellites.resize(3);
  EXPECT_FALSE(phase_displacement(a, few, here));
  RangeEpoch bad = b;
  for (CorrectedRange& s : bad.satellites) s.phase_m = std::nan("");
  EXPECT_FALSE(phase_displacement(a, bad, here));
  bad = b;
  for (CorrectedRange& s : bad.satellites) s.phase_interrupted = true;
  EXPECT_FALSE(phase_displacement(a, bad, here));
}

TEST(ConsistentInnovations, RemovesWhatTheOthersContradict) {
  const Eigen::MatrixXd common = Eigen::MatrixXd::Constant(5, 5, 100.0);
  Eigen::MatrixXd s = common;
  s.diagonal().array() += 0.01;
  Eigen::VectorXd nu = Eigen::VectorXd::Constant(5, 12.0);
  nu[3] += 1.0;
  EXPECT_EQ(consistent_innovations(nu, s, 4.0), (std::vector<bool>{true, true, true, false, true}));
  nu[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(consistent_innovations(nu, s, 4.0)[1]);
  EXPECT_TRUE(consistent_innovations(Eigen::VectorXd(), Eigen::MatrixXd(), 4.0).empty());
}

}  // namespace
}  // namespace wayfare
