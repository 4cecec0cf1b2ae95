// Groups, Gaussians, least squares, results and parallel loops with what they cannot use.

#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/levenberg_marquardt.hpp>
#include <wayfare/core/parallel.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::tests {
namespace {

template <class G>
struct GroupAbuse : ::testing::Test {};
using Groups = ::testing::Types<SO2d, SE2d, SO3d, SE3d, SE2f>;
TYPED_TEST_SUITE(GroupAbuse, Groups);

template <class G>
bool finite(const G& g) {
  return TangentOf<G>(g.log()).allFinite();
}

TYPED_TEST(GroupAbuse, ATangentThatIsNotFiniteGivesNoFiniteElement) {
  using Scalar = typename TypeParam::Scalar;
  for (const double odd : kNotFinite)
    for (int i = 0; i < TypeParam::kDof; ++i) {
      TangentOf<TypeParam> tau = TangentOf<TypeParam>::Constant(Scalar(0.1));
      tau[i] = Scalar(odd);
      EXPECT_FALSE(finite(TypeParam::exp(tau)));
      EXPECT_FALSE(finite(TypeParam::identity().plus(tau)));
      EXPECT_FALSE(finite(TypeParam::exp(tau) * TypeParam::identity()));
    }
}

TYPED_TEST(GroupAbuse, BillionsOfMetresAndTurnsAreElements) {
  using Scalar = typename TypeParam::Scalar;
  Rng rng(1);
  for (int i = 0; i < 2000; ++i) {
    TangentOf<TypeParam> tau;
    for (auto& t : tau) t = Scalar(rng.uniform(-1e9, 1e9));
    const TypeParam x = TypeParam::exp(tau);
    ASSERT_TRUE(finite(x)) << tau.transpose();
    ASSERT_TRUE(finite(x * x.inverse()));
    ASSERT_TRUE(SquareOf<TypeParam>(x.adjoint()).allFinite());
  }
  TangentOf<TypeParam> small =
      TangentOf<TypeParam>::Constant(std::numeric_limits<Scalar>::denorm_min());
  EXPECT_TRUE(finite(TypeParam::exp(small)));
  EXPECT_TRUE(finite(interpolate(TypeParam::exp(small), TypeParam::identity(), 0.5)));
}

TEST(RotationAbuse, BetweenVectorsOfAnyScaleIsARotation) {
  Rng rng(2);
  for (int i = 0; i < 2000; ++i) {
    Eigen::Vector3d a, b;
    for (double& x : a) x = rng.normal();
    for (double& x : b) x = rng.normal();
    if (i % 3 == 0) b = a;
    if (i % 3 == 1) b = -a;
    const double scale = std::pow(10.0, rng.uniform(-70.0, 70.0));
    const SO3d q = SO3d::between(scale * a, b);
    ASSERT_NEAR(q.quaternion().norm(), 1.0, 1e-12);
    ASSERT_LT((q * a.normalized() - b.normalized()).norm(), 1e-7);
  }
}

using G2 = Gaussian<SE2d>;

TEST(GaussianAbuse, ZeroInfiniteAndNaNCovariancesAreNamed) {
  const G2 good{SE2d(1, 2, Angle::radians(0.5)), Eigen::Matrix3d::Identity()};
  G2 zero = good;
  zero.covariance.setZero();
  EXPECT_TRUE(std::isnan(squared_mahalanobis(zero, good.mean)));
  EXPECT_TRUE(std::isnan(log_density(zero, good.mean)));
  EXPECT_FALSE(product(zero, zero));
  ASSERT_TRUE(product(zero, good));
  EXPECT_EQ(product(zero, good)->covariance, Eigen::Matrix3d::Zero());
  Rng rng(1);
  EXPECT_LT(sample(zero, rng).minus(zero.mean).norm(), 1e-15);
  for (const double odd : kNotFinite) {
    G2 bad = good;
    bad.covariance(1, 1) = odd;
    EXPECT_FALSE(product(bad, good));
    EXPECT_FALSE(product(good, bad));
    G2 nowhere = good;
    nowhere.mean = SE2d(odd, 0.0, Angle{});
    for (const auto& both : {product(good, nowhere), product(nowhere, good)}) {
      ASSERT_FALSE(both);
      EXPECT_EQ(both.error().code, ErrorCode::numerical);
    }
  }
}

TEST(GaussianAbuse, ScalesFromTinyToHugeAgree) {
  for (const double scale : {1e-100, 1e-20, 1e9, 1e100}) {
    const G2 a{SE2d(0, 0, Angle{}), scale * Eigen::Matrix3d::Identity()};
    const auto both = product(a, a);
    ASSERT_TRUE(both) << scale;
    EXPECT_NEAR(both->covariance(0, 0) / scale, 0.5, 1e-12);
    EXPECT_TRUE(compose(a, a).covariance.allFinite());
  }
}

TEST(FrameAbuse, AChainOfBillionsOfMetresComesBack) {
  const Transform2<frame::Map, frame::Odom> far(SE2d(1e9, -1e9, Angle::radians(1.0)));
  const Point2<frame::Odom> p{{1e9, 1e9}};
  EXPECT_LT(((far.inverse() * (far * p)).coordinates_m - p.coordinates_m).norm(), 1e-5);
  expect_value_semantics(far, [](auto& t) { return Eigen::Vector3d(t.raw().log()); });
}

// Least squares of functions that misbehave.
using R2 = ResidualAndJacobian<Eigen::Vector2d>;

TEST(LeastSquaresAbuse, NoResidualIsASolution) {
  const auto none = [](const Eigen::Vector2d&) {
    return R2{Eigen::VectorXd(0), Eigen::Matrix<double, -1, 2>(0, 2)};
  };
  const auto result = levenberg_marquardt(Eigen::Vector2d(3, 4), none);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->estimate, Eigen::Vector2d(3, 4));
  EXPECT_EQ(result->reason, StopReason::converged);
}

TEST(LeastSquaresAbuse, AStartThatIsNotFiniteIsAnError) {
  const auto line = [](const Eigen::Vector2d& x) {
    return R2{Eigen::Vector2d(x.x() - 1.0, x.y()), Eigen::Matrix2d::Identity()};
  };
  for (const double odd : kNotFinite) {
    const auto result = levenberg_marquardt(Eigen::Vector2d(odd, 0.0), line);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::numerical);
  }
  EXPECT_FALSE(levenberg_marquardt(Eigen::Vector2d(kHuge, 0.0), line));  // the cost overflows
  const auto far = levenberg_marquardt(Eigen::Vector2d(1e9, -1e9), line);
  ASSERT_TRUE(far);
  EXPECT_LT((far->estimate - Eigen::Vector2d(1.0, 0.0)).norm(), 1e-6);
}

TEST(LeastSquaresAbuse, RandomFunctionsNeverRaiseTheCostNorRunOn) {
  Rng rng(3);
  for (int run = 0; run < 500; ++run) {
    SCOPED_TRACE(run);
    const double scale = std::pow(10.0, rng.uniform(-12.0, 12.0));
    const double lie = rng.below(3) == 0 ? rng.uniform(-2.0, 2.0) : 1.0;
    const bool singular = rng.below(3) == 0;
    const double hole = rng.below(2) == 0 ? rng.uniform(-3.0, 3.0) : kInf;
    const auto f = [&](const Eigen::Vector2d& x) {
      R2 r{Eigen::Vector2d(scale * std::sin(x.x()), singular ? 0.0 : x.y() * x.y() - 2.0),
           Eigen::Matrix2d::Zero()};
      r.jacobian(0, 0) = lie * scale * std::cos(x.x());
      r.jacobian(1, 1) = singular ? 0.0 : 2.0 * x.y();
      if (x.x() > hole) r.residual[0] = kNan;
      return r;
    };
    const Eigen::Vector2d start(rng.uniform(-5.0, 5.0), rng.uniform(-5.0, 5.0));
    LevenbergMarquardtOptions options;
    options.max_iterations = static_cast<int>(rng.below(60));
    const auto result = levenberg_marquardt(start, f, options);
    const double before = 0.5 * f(start).residual.squaredNorm();
    ASSERT_EQ(result.has_value(), std::isfinite(before));
    if (!result) continue;
    ASSERT_TRUE(result->estimate.allFinite());
    ASSERT_LE(result->cost, before);
    ASSERT_EQ(result->cost, 0.5 * f(result->estimate).residual.squaredNorm());
    ASSERT_LE(result->iterations, options.max_iterations);
  }
}

TEST(ParallelAbuse, AnyNumberOfThreadsDoesEachIndexOnce) {
  for (const int threads :
       {std::numeric_limits<int>::min(), -1, 0, 1, 3, 1000, std::numeric_limits<int>::max()})
    for (const std::size_t n : {std::size_t{0}, std::size_t{1}, std::size_t{2000}}) {
      std::vector<std::atomic<int>> calls(n);
      std::atomic<bool> worker_in_range{true};
      double last = 0.0;
      parallel_for_workers(
          n, threads,
          [&](std::size_t i, std::size_t worker) {
            ++calls[i];
            if (worker >= static_cast<std::size_t>(std::max(threads, 1))) worker_in_range = false;
          },
          [&](double done) { last = done; });
      for (const auto& c : calls) ASSERT_EQ(c, 1);
      EXPECT_TRUE(worker_in_range);
      EXPECT_EQ(last, n == 0 ? 0.0 : 1.0);
    }
}

TEST(ParallelAbuse, LoopsWithinLoopsOnTwoThreads) {
  const auto sums = in_two_threads([](int) {
    std::vector<double> all(50);
    parallel_for(all.size(), 3, [&](std::size_t i) {
      std::vector<double> parts(20);
      parallel_for(parts.size(), 2, [&](std::size_t k) { parts[k] = static_cast<double>(i * k); });
      for (const double part : parts) all[i] += part;
    });
    return all;
  });
  EXPECT_EQ(sums[0], sums[1]);
}

TEST(ResultAbuse, LivesAsItsContent) {
  expect_value_semantics(Result<std::string>(std::string(100, 'x')),
                         [](auto& r) { return r.value_or("none"); });
  expect_value_semantics(
      Result<std::string>(Error{ErrorCode::parse, std::string(100, 'y'), "f", 3}),
      [](auto& r) { return r.error().to_string(); });
  expect_value_semantics(Result<void>(Error{ErrorCode::io, "gone"}),
                         [](auto& r) { return r.error().message; });
  expect_move_semantics([] { return Result<std::unique_ptr<int>>(std::make_unique<int>(3)); },
                        [](auto& r) { return **r; });
  // An Error as the value is a value.
  const Result<Result<int>> nested = Result<int>(Error{ErrorCode::invalid, "inner"});
  ASSERT_TRUE(nested);
  EXPECT_FALSE(*nested);
  EXPECT_EQ(Error{}.to_string(), "");
}

}  // namespace
}  // namespace wayfare::tests
