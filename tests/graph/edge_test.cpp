#include <wayfare/graph/edge.hpp>

#include <cmath>
#include <type_traits>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>

namespace wayfare {
namespace {

/// The place of a point seen by a camera whose focal length is estimated too, in pixels.
template <class How>
struct Pixel {
  using Variables = EdgeVariables<SE3d, Eigen::Vector3d, Eigen::Matrix<double, 1, 1>>;
  using Jacobians = How;
  static constexpr int kDim = 2;
  Eigen::Vector2d seen_px{10.0, -20.0};

  template <class T>
  Eigen::Matrix<T, 2, 1> error(const SE3<T>& camera, const Eigen::Matrix<T, 3, 1>& point,
                               const Eigen::Matrix<T, 1, 1>& focal_px) const {
    const Eigen::Matrix<T, 3, 1> p = camera.inverse() * point;
    return {focal_px[0] * p.x() / p.z() - T(seen_px.x()),
            focal_px[0] * p.y() / p.z() - T(seen_px.y())};
  }
};

/// The same by hand: d(f x/z, f y/z) = f/z (dx − x/z dz, dy − y/z dz).
struct AnalyticPixel : Pixel<void> {
  Eigen::Vector2d linearise(const SE3d& camera, const Eigen::Vector3d& point,
                            const Eigen::Matrix<double, 1, 1>& focal_px,
                            EdgeJacobians<2, Variables>& j) const {
    const Eigen::Vector3d p = camera.inverse() * point;
    const double scale = focal_px[0] / p.z();
    Eigen::Matrix<double, 2, 3> by_p;
    by_p << scale, 0.0, -scale * p.x() / p.z(), 0.0, scale, -scale * p.y() / p.z();
    auto& [by_camera, by_point, by_focal] = j.by;
    by_camera << -by_p, by_p * skew(p);
    by_point = by_p * camera.rotation().inverse().matrix();
    by_focal = p.head<2>() / p.z();
    return error(camera, point, focal_px);
  }
};

static_assert(Edge<AnalyticPixel> && Edge<Pixel<AutomaticJacobians>> &&
              Edge<Pixel<NumericJacobians>>);

// Three ways to the same Jacobians of three variables. Central differences with a step of 6e-6 on
// errors of about 500 px lose what rounding leaves: 500 ε / 6e-6, about 2e-8 times a few operations.
TEST(Edge, AnalyticAutomaticAndNumericJacobiansAgree) {
  Rng rng(1);
  const auto normal = [&](double sigma) { return sigma * rng.normal(); };
  for (int trial = 0; trial < 100; ++trial) {
    Eigen::Matrix<double, 6, 1> step;
    for (int i = 0; i < 6; ++i) step[i] = normal(0.2);
    const SE3d camera = SE3d::exp(step);
    const Eigen::Vector3d point(normal(1.0), normal(1.0), 5.0 + rng.uniform());
    const Eigen::Matrix<double, 1, 1> focal(500.0 + normal(10.0));
    JacobiansOf<AnalyticPixel> by_hand, automatic, numeric;
    const auto want = linearise(AnalyticPixel{}, by_hand, camera, point, focal);
    EXPECT_EQ(linearise(Pixel<NumericJacobians>{}, numeric, camera, point, focal), want);
    EXPECT_TRUE(linearise(Pixel<AutomaticJacobians>{}, automatic, camera, point, focal)
                    .isApprox(want, 1e-12));
    const auto compare = [&]<std::size_t I>(std::integral_constant<std::size_t, I>) {
      const auto& j = std::get<I>(by_hand.by);
      const double largest = j.cwiseAbs().maxCoeff();
      EXPECT_LT((std::get<I>(automatic.by) - j).cwiseAbs().maxCoeff(), 1e-12 * largest) << I;
      EXPECT_LT((std::get<I>(numeric.by) - j).cwiseAbs().maxCoeff(), 1e-7 * (1.0 + largest)) << I;
    };
    compare(std::integral_constant<std::size_t, 0>{});
    compare(std::integral_constant<std::size_t, 1>{});
    compare(std::integral_constant<std::size_t, 2>{});
  }
}

struct Level {
  using Variables = EdgeVariables<Eigen::Vector2d>;
  static constexpr int kDim = 2;
  Eigen::Matrix2d information = Eigen::Vector2d(4.0, 9.0).asDiagonal();
  Eigen::Vector2d error(const Eigen::Vector2d& x) const { return x; }
};

TEST(Edge, InformationAndKernelWeighTheError) {
  const Eigen::Vector2d x(1.0, 2.0);
  EXPECT_EQ(squared_error(Level{}, x), 4.0 + 36.0);
  EXPECT_EQ(robust_value(Level{}, 40.0).cost, 40.0);
  EXPECT_EQ(robust_value(Level{}, 40.0).weight, 1.0);
  // Huber at 2: ρ = 2·2·√40 − 4, ρ′ = 2/√40.
  const Robust<Level> huber{{}, {RobustKernelKind::huber, 2.0}};
  EXPECT_EQ(squared_error(huber, x), 40.0) << "the kernel is applied afterwards";
  EXPECT_DOUBLE_EQ(robust_value(huber, 40.0).cost, 4.0 * std::sqrt(40.0) - 4.0);
  EXPECT_DOUBLE_EQ(robust_value(huber, 40.0).weight, 2.0 / std::sqrt(40.0));
  // Without information the error is in standard deviations.
  EXPECT_NEAR(squared_error(Pixel<NumericJacobians>{}, SE3d(), Eigen::Vector3d(0.0, 0.0, 1.0),
                            Eigen::Matrix<double, 1, 1>(1.0)),
              100.0 + 400.0, 1e-12);
}

}  // namespace
}  // namespace wayfare
