#include <wayfare/eval/trajectory_error.hpp>

#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <wayfare/core/random.hpp>

namespace wayfare::eval {
namespace {

std::vector<Eigen::Vector2d> cloud(Rng& rng, int n) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < n; ++i) points.emplace_back(5 * rng.normal(), rng.normal());
  return points;
}

double cost(const SE2d& T, const std::vector<Eigen::Vector2d>& p,
            const std::vector<Eigen::Vector2d>& q) {
  double sum = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) sum += (T * p[i] - q[i]).squaredNorm();
  return sum;
}

TEST(Alignment, RecoversAnyRigidMotionExactly) {
  Rng rng(7);
  for (int k = 0; k < 50; ++k) {
    const SE2d truth(10 * rng.normal(), 10 * rng.normal(), Angle::radians(3 * rng.normal()));
    const auto p = cloud(rng, 2 + k);
    std::vector<Eigen::Vector2d> q;
    for (const auto& v : p) q.push_back(truth * v);
    EXPECT_LT((rigid_alignment(p, q).minus(truth)).norm(), 1e-10);
  }
}

TEST(Alignment, AgreesWithUmeyamaBySvdAndIsAMinimum) {
  Rng rng(8);
  for (int k = 0; k < 20; ++k) {
    const auto p = cloud(rng, 30), q = cloud(rng, 30);  // unrelated
    const SE2d T = rigid_alignment(p, q);
    Eigen::MatrixXd a(2, 30), b(2, 30);
    for (int i = 0; i < 30; ++i) {
      a.col(i) = p[static_cast<std::size_t>(i)];
      b.col(i) = q[static_cast<std::size_t>(i)];
    }
    const Eigen::MatrixXd oracle = Eigen::umeyama(a, b, false);
    const Eigen::Matrix2d rotation = oracle.topLeftCorner<2, 2>();
    const Eigen::Vector2d shift = oracle.topRightCorner<2, 1>();
    EXPECT_TRUE(T.rotation().matrix().isApprox(rotation, 1e-9));
    EXPECT_LT((T.translation() - shift).norm(), 1e-9);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = 1e-3 * Eigen::Vector3d::Unit(axis);
      EXPECT_GT(cost(T.plus(step), p, q), cost(T, p, q));
      EXPECT_GT(cost(T.plus(-step), p, q), cost(T, p, q));
    }
  }
}

TEST(Alignment, WithoutEnoughPointsOnlyTranslates) {
  EXPECT_EQ(rigid_alignment({}, {}).log().norm(), 0.0);
  const std::vector<Eigen::Vector2d> p = {{1, 2}}, q = {{4, 6}};
  const SE2d T = rigid_alignment(p, q);
  EXPECT_EQ(T.translation(), Eigen::Vector2d(3, 4));
  EXPECT_EQ(T.heading().radians(), 0.0);
}

}  // namespace
}  // namespace wayfare::eval
