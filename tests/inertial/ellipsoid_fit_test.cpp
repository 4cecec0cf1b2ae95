#include <wayfare/inertial/detail/ellipsoid_fit.hpp>

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <wayfare/core/random.hpp>

namespace wayfare {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Vector3d kCentre(40.0, -25.0, 110.0);
/// Half axes of about 33, 55 and 45, rotated.
const Matrix3d kMatrix =
    (Matrix3d() << 0.030, 0.002, -0.001, 0.002, 0.0185, 0.0005, -0.001, 0.0005, 0.022).finished();

/// On the ellipsoid with radial `noise`, relative to the radius.
std::vector<Vector3d> points(Rng& rng, int count, double noise = 0.0) {
  std::vector<Vector3d> result;
  for (int i = 0; i < count; ++i) {
    const double x = rng.normal(), y = rng.normal();
    const Vector3d u = Vector3d(x, y, rng.normal()).normalized();
    result.push_back(kCentre + kMatrix.inverse() * u * (1.0 + rng.normal(0.0, noise)));
  }
  return result;
}

TEST(EllipsoidFit, FindsAKnownEllipsoid) {
  Rng rng(1);
  for (const int count : {9, 12, 200}) {
    const auto fit = fit_ellipsoid(points(rng, count));
    ASSERT_TRUE(fit) << count << " points";
    EXPECT_LT((fit->centre - kCentre).norm(), 1e-6);
    EXPECT_LT((fit->matrix - kMatrix).norm(), 1e-9);
    EXPECT_LT(fit->residual, 1e-9);
    EXPECT_EQ(fit->matrix, fit->matrix.transpose());
  }
}

// Translated and scaled points give the translated and scaled ellipsoid.
TEST(EllipsoidFit, IsEquivariantUnderTranslationAndScale) {
  Rng rng(2);
  const auto original = points(rng, 100, 0.01);
  const auto fit = fit_ellipsoid(original);
  ASSERT_TRUE(fit);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    const Vector3d shift = scale * Vector3d(3e4, -1e4, 500.0);
    std::vector<Vector3d> moved;
    for (const Vector3d& p : original) moved.push_back(scale * p + shift);
    const auto other = fit_ellipsoid(moved);
    ASSERT_TRUE(other);
    EXPECT_LT((other->centre - (scale * fit->centre + shift)).norm(), 1e-6 * scale);
    EXPECT_LT((scale * other->matrix - fit->matrix).norm(), 1e-9);
    EXPECT_NEAR(other->residual, fit->residual, 1e-9);
  }
}

// The mean normalised squared error over many sets is one (200 sets: ±0.2 for four standard
// deviations of a parameter's mean).
TEST(EllipsoidFit, CovarianceMatchesTheErrors) {
  Rng rng(3);
  Eigen::Matrix<double, 9, 1> ratio = Eigen::Matrix<double, 9, 1>::Zero();
  constexpr int kSets = 200;
  for (int set = 0; set < kSets; ++set) {
    const auto fit = fit_ellipsoid(points(rng, 300, 0.02));
    ASSERT_TRUE(fit);
    const Matrix3d d = fit->matrix - kMatrix;
    Eigen::Matrix<double, 9, 1> error;
    error << fit->centre - kCentre, d(0, 0), d(1, 1), d(2, 2), d(0, 1), d(0, 2), d(1, 2);
    ratio += error.cwiseAbs2().cwiseQuotient(fit->covariance.diagonal()) / kSets;
  }
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(ratio[i], 1.0, 0.45) << "parameter " << i;
}

TEST(EllipsoidFit, IsRobustAgainstTenPercentOutliers) {
  Rng rng(4);
  auto with_outliers = points(rng, 400, 0.005);
  for (std::size_t i = 0; i < with_outliers.size(); i += 10)
    with_outliers[i] = kCentre + 1.5 * (with_outliers[i] - kCentre);
  const auto fit = fit_ellipsoid(with_outliers);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->centre - kCentre).norm(), 0.3);
  EXPECT_NEAR(fit->matrix.determinant() / kMatrix.determinant(), 1.0, 0.02);
  EXPECT_NEAR(fit->residual, 0.005, 0.0015);
}

TEST(EllipsoidFit, RejectsPointsThatDoNotDetermineIt) {
  Rng rng(5);
  EXPECT_FALSE(fit_ellipsoid({}));
  EXPECT_FALSE(fit_ellipsoid(points(rng, 8)));
  EXPECT_FALSE(fit_ellipsoid(std::vector<Vector3d>(50, kCentre)));
  std::vector<Vector3d> flat, line, repeated;
  const auto few = points(rng, 8);
  for (int i = 0; i < 100; ++i) {
    const double a = 0.0628 * i;
    flat.push_back(kCentre + 50.0 * Vector3d(std::cos(a), std::sin(a), 0.0));
    line.push_back(kCentre + i * Vector3d(1.0, 2.0, -1.0));
    repeated.push_back(few[static_cast<std::size_t>(i) % few.size()]);
  }
  EXPECT_FALSE(fit_ellipsoid(flat));
  EXPECT_FALSE(fit_ellipsoid(line));
  EXPECT_FALSE(fit_ellipsoid(repeated));
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e308}) {
    auto corrupted = points(rng, 50);
    corrupted[17].y() = bad;
    EXPECT_FALSE(fit_ellipsoid(corrupted)) << bad;
  }
}

}  // namespace
}  // namespace wayfare
