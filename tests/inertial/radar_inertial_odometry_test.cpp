// Radar-inertial odometry on synthetic carriers of known motion.

#include <wayfare/inertial/radar_inertial_odometry.hpp>

#include <cmath>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

/// A carrier on a rounded path with changing heights, tilts and turns: 200 Hz unit, 10 Hz radar.
struct CarriedRadar {
  std::vector<ImuSample> unit;
  std::vector<RadarVelocity> radar;
  std::vector<Eigen::Vector3d> positions_m;  // at each velocity
  RadarInertialOptions options;
};

Eigen::Vector3d place_at(double t) {
  if (t < 3.0) return Eigen::Vector3d::Zero();
  const double s = t - 3.0, soft = s * s / (s * s + 4.0);
  return soft * Eigen::Vector3d(2.0 * std::sin(0.5 * s), 1.5 * (1.0 - std::cos(0.4 * s)),
                                0.3 * std::sin(0.8 * s));
}
SO3d attitude_at(double t) {
  if (t < 3.0) return SO3d();
  const double s = t - 3.0;
  return SO3d::exp({0.0, 0.0, 0.6 * std::sin(0.3 * s)}) *
         SO3d::exp({0.15 * std::sin(0.9 * s), 0.1 * std::sin(0.7 * s), 0.0});
}

CarriedRadar carried_radar(double duration_s, std::uint64_t seed, double outliers = 0.0) {
  CarriedRadar c;
  c.options.q_unit_radar = SO3d::exp({0.1, -0.3, 2.0});
  c.options.lever_m = {0.05, -0.03, 0.02};
  Rng rng(seed);
  constexpr double kStep_s = 0.005, kSmall_s = 1e-4;
  const Eigen::Vector3d gyro_bias(0.004, -0.003, 0.005), up(0.0, 0.0, c.options.gravity_mps2);
  const auto noise = [&](double sigma) {
    return Eigen::Vector3d(sigma * rng.normal(), sigma * rng.normal(), sigma * rng.normal());
  };
  const auto rate_at = [&](double t) {
    return Eigen::Vector3d(attitude_at(t + kSmall_s).minus(attitude_at(t - kSmall_s)) /
                           (2.0 * kSmall_s));
  };
  for (int i = 0; i * kStep_s < duration_s; ++i) {
    const double t = i * kStep_s, middle = t - 0.5 * kStep_s;
    constexpr double kWide_s = 1e-3;
    const Eigen::Vector3d acceleration =
        (place_at(middle + kWide_s) - 2.0 * place_at(middle) + place_at(middle - kWide_s)) /
        (kWide_s * kWide_s);
    const LogTime now = LogTime::from_seconds(50.0 + t);
    c.unit.push_back({now, rate_at(middle) + gyro_bias + noise(0.002),
                      attitude_at(middle).inverse() * (acceleration + up) + noise(0.05)});
    if (i % 20 != 10) continue;
    const Eigen::Vector3d v = (place_at(t + kWide_s) - place_at(t - kWide_s)) / (2.0 * kWide_s);
    const Eigen::Vector3d at_radar =
        attitude_at(t).inverse() * v + rate_at(t).cross(c.options.lever_m);
    RadarVelocity found;
    found.time = now + Duration(1000);
    found.velocity_m_s = c.options.q_unit_radar.inverse() * at_radar + noise(0.04);
    if (rng.uniform() < outliers) found.velocity_m_s += noise(3.0);
    found.covariance = 0.04 * 0.04 * Eigen::Matrix3d::Identity();
    c.radar.push_back(found);
    c.positions_m.push_back(place_at(t));
  }
  return c;
}

double largest_error(const CarriedRadar& c, const RadarInertialRun& run) {
  double most = 0.0;
  const std::size_t early = c.radar.size() - run.estimates.size();
  for (std::size_t i = 0; i < run.estimates.size(); ++i)
    most = std::max(most, (run.estimates[i].position_m - c.positions_m[i + early]).norm());
  return most;
}

TEST(RadarInertialOdometry, FollowsAKnownPath) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
    const CarriedRadar c = carried_radar(40.0, seed);
    const RadarInertialRun run = run_radar_inertial(c.unit, c.radar, c.options);
    ASSERT_GT(run.estimates.size() + 5, c.radar.size());
    EXPECT_LT(largest_error(c, run), 0.75) << "of some 30 m, seed " << seed;
    EXPECT_LT(run.counts.rejected, run.counts.velocities / 20);
  }
}

TEST(RadarInertialOdometry, RejectsOutliers) {
  const CarriedRadar c = carried_radar(40.0, 6, 0.15);
  const RadarInertialRun run = run_radar_inertial(c.unit, c.radar, c.options);
  EXPECT_LT(largest_error(c, run), 0.9);
  EXPECT_GT(run.counts.rejected, c.radar.size() / 20);
}

TEST(RadarInertialOdometry, AccelerometersBridgeASilentRadar) {
  CarriedRadar c = carried_radar(20.0, 7);
  const auto in_gap = [&](LogTime t) {
    const double s = to_seconds(t - c.unit.front().time);
    return s > 10.0 && s < 11.5;
  };
  std::size_t i = 0;
  std::erase_if(c.positions_m, [&](const auto&) { return in_gap(c.radar[i++].time); });
  std::erase_if(c.radar, [&](const RadarVelocity& v) { return in_gap(v.time); });
  EXPECT_LT(largest_error(c, run_radar_inertial(c.unit, c.radar, c.options)), 0.5);
}

TEST(RadarInertialOdometry, ReversedInTimeItReturns) {
  const CarriedRadar c = carried_radar(30.0, 8);
  const LogTime middle = LogTime::from_seconds(65.0);
  const auto there = run_radar_inertial(c.unit, c.radar, c.options);
  const auto back = run_radar_inertial(reversed_in_time(c.unit, middle),
                                       reversed_in_time(c.radar, middle), c.options);
  const Eigen::Vector3d out =
      there.estimates.back().position_m - there.estimates.front().position_m;
  const Eigen::Vector3d home = back.estimates.back().position_m - back.estimates.front().position_m;
  EXPECT_NEAR(out.norm(), home.norm(), 0.6);
  EXPECT_NEAR(out.z(), -home.z(), 0.4);
}

TEST(RadarInertialOdometry, RefusesBadReadings) {
  const CarriedRadar c = carried_radar(5.0, 9);
  RadarInertialOdometry odometry(c.options);
  RadarVelocity bad = c.radar.front();
  EXPECT_EQ(odometry.add(bad), UpdateStatus::waiting);
  EXPECT_FALSE(odometry.estimate());
  for (const ImuSample& s : c.unit) (void)odometry.add(s);
  const auto before = odometry.estimate();
  ASSERT_TRUE(before);
  EXPECT_EQ(odometry.add(c.unit.front()), UpdateStatus::late);
  ImuSample broken = c.unit.back();
  broken.time += Duration(5'000'000);
  broken.angular_rate_radps.x() = NAN;
  EXPECT_EQ(odometry.add(broken), UpdateStatus::missing);
  bad.velocity_m_s.x() = NAN;
  EXPECT_EQ(odometry.add(bad), UpdateStatus::missing);
  EXPECT_EQ(odometry.estimate()->position_m, before->position_m);
}

}  // namespace
}  // namespace wayfare
