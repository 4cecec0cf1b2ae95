// Gyro heading drift from a magnetometer with unknown hard iron.
#include <wayfare/pedestrian/detail/magnetic_heading_drift.hpp>

#include <cmath>
#include <cstdint>
#include <numbers>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include "phone_walk.hpp"

namespace wayfare {
namespace {

using testing::PhoneWalk;
using testing::PhoneWalkOptions;
using testing::walk_phone;

MagneticHeadingDriftParameters uncalibrated() {
  MagneticHeadingDriftParameters p;
  p.offset_sigma_uT = 50.0;
  return p;
}

struct CircuitOptions {
  double duration_s = 240.0;
  double leg_s = 15.0;  ///< straight, then a quarter turn
  double bias_radps = 0.012;
  Eigen::Vector3d offset_uT{-30.0, 22.0, 15.0};
  double disturbance_uT = 4.0;  ///< Gauss-Markov, 2 s
  std::uint64_t seed = 1;
};

/// Rectangular circuits with a nodding head; `each(i, reading)` may modify the readings.
template <class Each>
MagneticHeadingDrift walk_circuit(const CircuitOptions& o, MagneticHeadingDrift drift, Each each) {
  Rng rng(o.seed);
  Eigen::Vector3d disturbance = Eigen::Vector3d::Zero();
  const double dt = 0.05, decay = std::exp(-dt / 2.0);
  for (int i = 0; i < static_cast<int>(o.duration_s / dt); ++i) {
    const double t = i * dt, leg = std::floor(t / o.leg_s), into = t - leg * o.leg_s;
    const double heading = 0.5 * std::numbers::pi * (leg + std::min(1.0, std::max(0.0, into)));
    const SO3d nod = SO3d::exp({0.1 * std::sin(1.3 * t), 0.15 * std::sin(0.7 * t), 0.0});
    const SO3d truth = SO3d::exp({0.0, 0.0, heading}) * nod;
    const SO3d by_gyro = SO3d::exp({0.0, 0.0, heading + o.bias_radps * t}) * nod;
    for (int k = 0; k < 3; ++k)
      disturbance[k] =
          decay * disturbance[k] + o.disturbance_uT * std::sqrt(1.0 - decay * decay) * rng.normal();
    Eigen::Vector3d reading =
        truth.inverse() * (Eigen::Vector3d(0.0, 20.0, -44.0) + disturbance) + o.offset_uT;
    each(i, reading);
    drift.add(LogTime::from_nanoseconds(std::llround((t + 1.0) * 1e9)), by_gyro, reading);
  }
  return drift;
}
MagneticHeadingDrift walk_circuit(const CircuitOptions& o) {
  return walk_circuit(o, MagneticHeadingDrift(uncalibrated()), [](int, Eigen::Vector3d&) {});
}
double drift_error(const CircuitOptions& o, const MagneticHeadingDrift& drift) {
  return drift.correction() + o.bias_radps * (o.duration_s - 0.05);
}

// The gyro alone has an error of 165° at the end.
TEST(MagneticHeadingDrift, SeparatesDriftAndOffsetByTurns) {
  const CircuitOptions o;
  const MagneticHeadingDrift drift = walk_circuit(o);
  EXPECT_LT(std::abs(drift_error(o, drift)), 0.1);
  EXPECT_NEAR(drift.rate_radps(), -o.bias_radps, 0.001);
  EXPECT_LT((drift.offset_uT() - o.offset_uT).head<2>().norm(), 4.0);
  EXPECT_LT((drift.offset_sigma_uT()).head<2>().norm(), 3.0);
}

// Seventy-two errors of one degree of freedom each: bounds of their mean square at 99.9 %.
TEST(MagneticHeadingDrift, ErrorsHaveTheirVariance) {
  double squares = 0.0;
  int n = 0;
  for (std::uint64_t seed = 1; seed <= 18; ++seed) {
    Rng rng(seed + 100);
    auto p = uncalibrated();
    p.offset_sigma_uT = 20.0;
    p.rate_noise = 0.0;
    p.bias_walk = 0.0;
    CircuitOptions o;
    o.seed = seed;
    o.duration_s = 120.0;
    o.bias_radps = p.bias_sigma * rng.normal();
    for (int k = 0; k < 3; ++k) o.offset_uT[k] = 20.0 * rng.normal();
    const MagneticHeadingDrift drift =
        walk_circuit(o, MagneticHeadingDrift(p), [](int, Eigen::Vector3d&) {});
    squares += std::pow(drift_error(o, drift), 2) / drift.variance();
    for (int k = 0; k < 3; ++k)
      squares += std::pow((drift.offset_uT() - o.offset_uT)[k] / drift.offset_sigma_uT()[k], 2);
    n += 4;
  }
  EXPECT_EQ(n, 72);
  EXPECT_GT(squares / n, 0.53);
  EXPECT_LT(squares / n, 1.65);
}

TEST(MagneticHeadingDrift, IsIndependentOfMounting) {
  const CircuitOptions o;
  const SO3d mounted = SO3d::exp({1.0, -0.7, 2.0});
  MagneticHeadingDrift turned{uncalibrated()}, straight{uncalibrated()};
  for (int i = 0; i < 600; ++i) {
    const auto time = LogTime::from_nanoseconds(std::int64_t{50'000'000} * (i + 1));
    const SO3d q = SO3d::exp({0.1 * std::sin(0.1 * i), 0.0, 0.02 * i});
    const Eigen::Vector3d reading =
        SO3d::exp({0.1 * std::sin(0.1 * i), 0.0, 0.0195 * i}).inverse() *
            Eigen::Vector3d(0.0, 20.0, -44.0) +
        o.offset_uT;
    straight.add(time, q, reading);
    turned.add(time, q * mounted, mounted.inverse() * reading);
  }
  EXPECT_NEAR(turned.correction(), straight.correction(), 1e-9);
  EXPECT_NEAR(turned.variance(), straight.variance(), 1e-9);
  EXPECT_LT((mounted * turned.offset_uT() - straight.offset_uT()).norm(), 1e-6);
}

// Without turns only nods separate iron from field, and the uncertainty stays large.
TEST(MagneticHeadingDrift, OffsetStaysUnknownWithoutTurns) {
  CircuitOptions o;
  o.leg_s = 1e9;
  o.duration_s = 60.0;
  o.bias_radps = 0.0;
  const MagneticHeadingDrift drift =
      walk_circuit(o, MagneticHeadingDrift(uncalibrated()), [](int i, Eigen::Vector3d& m) {
        if (i < 20) m.setConstant(std::nan(""));  // the turn at the start
      });
  EXPECT_GT(drift.offset_sigma_uT().head<2>().minCoeff(), 3.0);
  EXPECT_LT(std::abs(drift_error(o, drift)), 3.0 * std::sqrt(drift.variance()));
}

TEST(MagneticHeadingDrift, MagnetNearbyIsRejected) {
  const CircuitOptions o;
  const MagneticHeadingDrift drift =
      walk_circuit(o, MagneticHeadingDrift(uncalibrated()), [](int i, Eigen::Vector3d& m) {
        if (i > 2400 && i < 2600) m.x() += 150.0;
      });
  EXPECT_GT(drift.report().disturbed, 90U);  // ten seconds at 10 Hz
  EXPECT_LT(std::abs(drift_error(o, drift)), 0.12);
}

TEST(MagneticHeadingDrift, PersistentFieldIsLearned) {
  const CircuitOptions o;
  const MagneticHeadingDrift drift =
      walk_circuit(o, MagneticHeadingDrift(uncalibrated()), [](int i, Eigen::Vector3d& m) {
        if (i > 2400) m += Eigen::Vector3d(-80.0, 60.0, 0.0);  // iron attached to the unit
      });
  EXPECT_LT(drift.report().disturbed, 260U);
  EXPECT_LT((drift.offset_uT() - o.offset_uT - Eigen::Vector3d(-80.0, 60.0, 0.0)).head<2>().norm(),
            8.0);
  EXPECT_LT(std::abs(drift_error(o, drift)), 0.25);
}

TEST(MagneticHeadingDrift, MissingLateAndHugeReadings) {
  const CircuitOptions o;
  MagneticHeadingDrift drift =
      walk_circuit(o, MagneticHeadingDrift(uncalibrated()), [](int i, Eigen::Vector3d& m) {
        if (i % 7 == 0) m.y() = std::nan("");
        if (i % 1001 == 1000) m.z() = 1e30;
      });
  EXPECT_EQ(drift.report().missing, 686U);  // every seventh of 4800
  EXPECT_LT(std::abs(drift_error(o, drift)), 0.12);
  const double before = drift.correction();
  EXPECT_EQ(drift.add(LogTime::from_nanoseconds(5), SO3d(), {20.0, 0.0, 0.0}), UpdateStatus::late);
  EXPECT_EQ(drift.correction(), before);
}

// A walk along long bends with iron at the phone and a gyro drift of 22° in three minutes.
TEST(MagneticHeadingDrift, CorrectsAWalk) {
  PhoneWalkOptions o;
  o.steps = 300;
  o.start_rad = 0.5 * std::numbers::pi;
  PhoneWalk walk = walk_phone(o);
  for (auto& s : walk.samples) {
    s.angular_rate_radps.z() += 0.004;
    s.magnetic_field_uT += Eigen::Vector3d(-30.0, 20.0, 10.0);
  }
  PedestrianParameters p;
  p.length = ConstantStep{1.0};
  p.ahrs.rest_rate_density = 1e3;  // the initial rest would reveal the bias
  const auto heading_error = [&](double offset_sigma_uT, bool magnetometer) {
    p.magnetic_drift.offset_sigma_uT = offset_sigma_uT;
    p.ahrs.use_magnetometer = magnetometer;
    Pedestrian pedestrian(p);
    for (const auto& s : walk.samples) pedestrian.add(s);
    return std::abs(wrap_to_pi(pedestrian.pose().heading.radians() - walk.heading_rad));
  };
  EXPECT_GT(heading_error(0.0, false), 0.3);
  EXPECT_GT(heading_error(0.0, true), 0.3);
  EXPECT_LT(heading_error(50.0, true), 0.15);
}

}  // namespace
}  // namespace wayfare
