// Radar ego-velocity on synthetic frames of known motion.

#include <wayfare/motion/radar_velocity.hpp>

#include <cmath>

#include <gmock/gmock.h>
#include <Eigen/LU>

namespace wayfare {
namespace {

using ::testing::HasSubstr;

/// Points in all directions within 40 degrees of elevation, for a radar that moves with `v`.
RadarScan frame(const Eigen::Vector3d& v, std::size_t points, double noise, Rng& rng) {
  RadarScan scan;
  for (std::size_t i = 0; i < points; ++i) {
    const double bearing = 6.28 * rng.uniform(), up = 1.4 * (rng.uniform() - 0.5);
    const double range = 1.0 + 9.0 * rng.uniform();
    const Eigen::Vector3d at =
        range * Eigen::Vector3d(std::cos(bearing) * std::cos(up), std::sin(bearing) * std::cos(up),
                                std::sin(up));
    const double doppler = -v.dot(at) / range + noise * rng.normal();
    scan.points.push_back({static_cast<float>(at.x()), static_cast<float>(at.y()),
                           static_cast<float>(at.z()), static_cast<float>(doppler), 15.0F});
  }
  return scan;
}

TEST(RadarVelocity, IsExactWithoutNoise) {
  Rng rng(1);
  for (const Eigen::Vector3d& v : {Eigen::Vector3d(1.0, -0.5, 0.2), Eigen::Vector3d(0, 0, 0),
                                   Eigen::Vector3d(-3.0, 2.0, 0.0)}) {
    const auto found = radar_velocity(frame(v, 40, 0.0, rng), Rng(7));
    ASSERT_TRUE(found) << found.error().to_string();
    EXPECT_LT((found->velocity_m_s - v).norm(), 1e-5);  // points are single precision
    EXPECT_EQ(found->inliers, 40U);
  }
}

TEST(RadarVelocity, RejectsMovingPoints) {
  Rng rng(2);
  const Eigen::Vector3d v(0.8, 0.1, -0.1);
  RadarScan scan = frame(v, 60, 0.0, rng);
  for (std::size_t i = 0; i < 24; ++i)  // 40 percent
    scan.points[i].doppler_m_s += static_cast<float>((i % 2 == 0 ? 1 : -1) * (0.4 + rng.uniform()));
  const auto found = radar_velocity(scan, Rng(7));
  ASSERT_TRUE(found) << found.error().to_string();
  EXPECT_LT((found->velocity_m_s - v).norm(), 1e-5);
  EXPECT_EQ(found->inliers, 36U);
  EXPECT_FALSE(found->inlier[0]);
  EXPECT_TRUE(found->inlier[24]);
  const auto again = radar_velocity(scan, Rng(7));
  EXPECT_EQ(again->velocity_m_s, found->velocity_m_s);
}

/// The mean of eᵀ P⁻¹ e is the number of unknowns where the covariance is right: 3 ± 3.3 standard
/// deviations of a mean of 400 such numbers, each √6 wide.
TEST(RadarVelocity, CovarianceIsConsistent) {
  Rng rng(3);
  double sum = 0.0;
  constexpr int kTimes = 400;
  for (int i = 0; i < kTimes; ++i) {
    const Eigen::Vector3d v(rng.normal(), rng.normal(), 0.3 * rng.normal());
    const auto found =
        radar_velocity(frame(v, 150, 0.04, rng), rng.stream(static_cast<std::uint64_t>(i)));
    ASSERT_TRUE(found);
    const Eigen::Vector3d e = found->velocity_m_s - v;
    sum += e.dot(found->covariance.inverse() * e);
  }
  EXPECT_NEAR(sum / kTimes, 3.0, 3.3 * std::sqrt(6.0 / kTimes));
}

TEST(RadarVelocity, InThePlaneElevationIsNotRequired) {
  Rng rng(4);
  RadarScan scan = frame({1.0, 0.5, 0.0}, 30, 0.0, rng);
  for (RadarPoint& p : scan.points) {
    p.z_m = 0.0F;
    p.doppler_m_s = -(1.0F * p.x_m + 0.5F * p.y_m) / std::hypot(p.x_m, p.y_m);
  }
  EXPECT_FALSE(radar_velocity(scan, Rng(1)));  // the vertical is not observable
  const auto found = radar_velocity(scan, Rng(1), {.plane = true});
  ASSERT_TRUE(found) << found.error().to_string();
  EXPECT_LT((found->velocity_m_s - Eigen::Vector3d(1.0, 0.5, 0.0)).norm(), 1e-5);
  EXPECT_EQ(found->covariance(2, 2), 0.0);
}

TEST(RadarVelocity, RejectsDegenerateFrames) {
  Rng rng(5);
  const auto why = [](const RadarScan& scan) {
    const auto found = radar_velocity(scan, Rng(1));
    return found ? "no error" : found.error().to_string();
  };
  EXPECT_THAT(why({}), HasSubstr("has 0 points, for 3 unknowns"));
  RadarScan line;
  for (int i = 1; i < 20; ++i) line.points.push_back({static_cast<float>(i), 0, 0, -1.0F, 9.0F});
  EXPECT_THAT(why(line), HasSubstr("too few directions"));
  RadarScan noise = frame({0, 0, 0}, 40, 3.0, rng);
  EXPECT_THAT(why(noise), HasSubstr("agree"));
  RadarScan bad = frame({1, 0, 0}, 20, 0.0, rng);
  for (RadarPoint& p : bad.points) p.doppler_m_s = NAN;
  EXPECT_THAT(why(bad), HasSubstr("has 0 points"));
}

}  // namespace
}  // namespace wayfare
