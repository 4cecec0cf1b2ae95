#include <wayfare/graph/pose_graph.hpp>

#include <numbers>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare {
namespace {

template <class G>
G random_pose(Rng& rng, double turn) {
  TangentOf<G> tau;
  for (auto& t : tau) t = rng.uniform(-turn, turn);
  return G::exp(tau);
}

template <class G>
class PoseErrorTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(PoseErrorTest, Groups);

TYPED_TEST(PoseErrorTest, IsZeroIfTheMeasurementIsExact) {
  Rng rng(1);
  const auto from = random_pose<TypeParam>(rng, 2.0), z = random_pose<TypeParam>(rng, 2.0);
  EXPECT_LT(PoseError<TypeParam>::error(z, from, from * z).norm(), 1e-14);
}

TYPED_TEST(PoseErrorTest, JacobiansMatchCentralDifferences) {
  using G = TypeParam;
  Rng rng(2);
  constexpr double kStep = 1e-6;
  for (int trial = 0; trial < 50; ++trial) {
    const G z = random_pose<G>(rng, 1.5), from = random_pose<G>(rng, 1.5);
    // Near the measurement, so that the heading does not wrap within a step.
    const G to = from * z * random_pose<G>(rng, 0.8);
    const auto l = PoseError<G>::linearise(z, from, to);
    EXPECT_LT((l.error - PoseError<G>::error(z, from, to)).norm(), 1e-14);
    for (int k = 0; k < G::kDof; ++k) {
      TangentOf<G> d = TangentOf<G>::Zero();
      d[k] = kStep;
      const auto by_from =
          ((PoseError<G>::error(z, from.plus(d), to) - PoseError<G>::error(z, from.plus(-d), to)) /
           (2 * kStep))
              .eval();
      const auto by_to =
          ((PoseError<G>::error(z, from, to.plus(d)) - PoseError<G>::error(z, from, to.plus(-d))) /
           (2 * kStep))
              .eval();
      EXPECT_LT((l.by_from.col(k) - by_from).norm(), 1e-8);
      EXPECT_LT((l.by_to.col(k) - by_to).norm(), 1e-8);
    }
  }
}

TEST(PoseError, UsesTheTranslationWithoutTheLogarithm) {
  // Z = identity: the error is the relative pose itself, not its logarithm.
  const SE2d to(1.0, 2.0, 1.0_rad);
  const Eigen::Vector3d e = PoseError<SE2d>::error(SE2d(), SE2d(), to);
  EXPECT_NEAR((e - Eigen::Vector3d(1.0, 2.0, 1.0)).norm(), 0.0, 1e-15);
}

TEST(PoseError, SpatialRotationIsTheVectorPartOfTheUpperQuaternion) {
  // A rotation of 1.5 π about z equals one of −π/2: vector part −sin(π/4).
  const SE3d to(Eigen::Vector3d(1, 2, 3), SO3d(Eigen::Quaterniond(Eigen::AngleAxisd(
                                              1.5 * std::numbers::pi, Eigen::Vector3d::UnitZ()))));
  const auto e = PoseError<SE3d>::error(SE3d(), SE3d(), to);
  EXPECT_NEAR(e[5], -std::sin(std::numbers::pi / 4), 1e-14);
  EXPECT_NEAR((e.head<3>() - Eigen::Vector3d(1, 2, 3)).norm(), 0.0, 1e-15);
}

}  // namespace
}  // namespace wayfare
