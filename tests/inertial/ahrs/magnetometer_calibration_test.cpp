#include <wayfare/inertial/magnetometer_calibration.hpp>

#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se3.hpp>

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using Readings = std::vector<Eigen::Vector3d>;

const Eigen::Vector3d kOffset(35.0, -60.0, 12.0);
const Eigen::Matrix3d kSoftIron =
    (Eigen::Matrix3d() << 1.1, 0.05, -0.03, 0.05, 0.9, 0.08, -0.03, 0.08, 1.02).finished();

Eigen::Vector3d direction(Rng& rng) {
  const double x = rng.normal(), y = rng.normal();
  return Eigen::Vector3d(x, y, rng.normal()).normalized();
}

/// Readings of a 48 µT field in all directions with that hard and soft iron.
Readings rotated_readings(std::size_t n, double noise_uT, std::uint64_t seed) {
  Rng rng(seed);
  Readings readings;
  for (std::size_t i = 0; i < n; ++i) {
    readings.push_back(kSoftIron * (48.0 * direction(rng)) + kOffset);
    for (double& x : readings.back()) x += rng.normal(0.0, noise_uT);
  }
  return readings;
}

TEST(MagnetometerCalibration, FindsTheIronExactlyWithoutNoise) {
  MagnetometerCalibrationOptions options;
  options.field_uT = 48.0;
  const auto c = calibrate_magnetometer(rotated_readings(200, 0.0, 1), options);
  ASSERT_TRUE(c) << c.error().to_string();
  EXPECT_LT((c->offset_uT - kOffset).norm(), 1e-8);
  EXPECT_LT((c->correction - kSoftIron.inverse()).norm(), 1e-9);
  EXPECT_LT(c->residual_uT, 1e-8);
  EXPECT_LT(
      ((*c)(kSoftIron * Eigen::Vector3d(0, 48, 0) + kOffset) - Eigen::Vector3d(0, 48, 0)).norm(),
      1e-7);
}

TEST(MagnetometerCalibration, WithoutAFieldKeepsTheMeanStrength) {
  const auto c = calibrate_magnetometer(rotated_readings(200, 0.0, 2));
  ASSERT_TRUE(c);
  EXPECT_NEAR(c->correction.determinant(), 1.0, 1e-9);
  EXPECT_NEAR(c->field_uT, 48.0 * std::cbrt(kSoftIron.determinant()), 1e-7);
}

TEST(MagnetometerCalibration, UncertaintyMatchesTheErrors) {
  MagnetometerCalibrationOptions options;
  options.field_uT = 48.0;
  double squares = 0.0;
  constexpr int kRuns = 60;
  for (int k = 0; k < kRuns; ++k) {
    const auto c = calibrate_magnetometer(
        rotated_readings(300, 0.5, 100 + static_cast<std::uint64_t>(k)), options);
    ASSERT_TRUE(c);
    EXPECT_NEAR(c->residual_uT, 0.5, 0.12);
    squares += (c->offset_uT - kOffset).cwiseQuotient(c->offset_sigma_uT).squaredNorm();
    squares += (c->correction - kSoftIron.inverse())
                   .diagonal()
                   .cwiseQuotient(c->correction_sigma.diagonal())
                   .squaredNorm();
  }
  // χ² of 6 degrees of freedom per run: mean 6, deviation of the mean √(12/60) = 0.45.
  EXPECT_NEAR(squares / kRuns, 6.0, 1.8);
}

TEST(MagnetometerCalibration, IsRobustAgainstOutliers) {
  Readings readings = rotated_readings(400, 0.3, 3);
  Rng rng(4);
  for (std::size_t i = 0; i < readings.size(); i += 20) readings[i] += 40.0 * direction(rng);
  MagnetometerCalibrationOptions options;
  options.field_uT = 48.0;
  const auto c = calibrate_magnetometer(readings, options);
  ASSERT_TRUE(c) << c.error().to_string();
  EXPECT_LT((c->offset_uT - kOffset).norm(), 0.5);
}

TEST(MagnetometerCalibration, RejectsTooLittleRotation) {
  const auto message = [](const Readings& readings) {
    const auto c = calibrate_magnetometer(readings);
    return c ? std::string("calibrated") : c.error().message;
  };
  Rng rng(5);
  const Readings at_rest(5000, Eigen::Vector3d(20.0, 3.0, -40.0));
  EXPECT_THAT(message(at_rest), HasSubstr("hardly rotated"));
  EXPECT_THAT(message({}), HasSubstr("hardly rotated"));
  Readings level, cap;
  for (int i = 0; i < 1000; ++i) {
    const double a = 0.3 * i;
    const Eigen::Vector3d noise = 0.2 * direction(rng);
    level.push_back(Eigen::Vector3d(20.0 * std::cos(a), 20.0 * std::sin(a), -42.0) + noise);
    // Never more than 25° from one direction.
    const double tilt = 0.44 * rng.uniform();
    cap.push_back(48.0 * Eigen::Vector3d(std::sin(tilt) * std::cos(a), std::sin(tilt) * std::sin(a),
                                         std::cos(tilt)) +
                  noise);
  }
  EXPECT_THAT(message(level), HasSubstr("rotate the sensor slowly through all orientations"));
  EXPECT_THAT(message(cap), HasSubstr("rotate the sensor slowly through all orientations"));
}

TEST(MagnetometerCalibration, RejectsReadingsOffAnEllipsoid) {
  Rng rng(6);
  Readings junk;
  for (int i = 0; i < 1000; ++i) junk.push_back(50.0 * rng.uniform() * direction(rng));
  const auto c = calibrate_magnetometer(junk);
  ASSERT_FALSE(c);
  EXPECT_FALSE(c.error().message.empty());
}

TEST(MagnetometerCalibration, IgnoresMissingReadings) {
  Readings readings = rotated_readings(300, 0.0, 7);
  for (std::size_t i = 0; i < readings.size(); i += 3)
    readings[i].setConstant(i % 2 == 0 ? std::nan("") : 0.0);
  const auto c = calibrate_magnetometer(readings);
  ASSERT_TRUE(c);
  EXPECT_LT((c->offset_uT - kOffset).norm(), 1e-6);
  EXPECT_LE(c->used, 200U);
}

}  // namespace
}  // namespace wayfare
