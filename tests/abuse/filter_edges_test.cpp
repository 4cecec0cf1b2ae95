// Filters, particle weights and covariances at and beyond the border of what they can use.

#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/pack.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/filter/covariance_intersection.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/filter/gauss_markov.hpp>
#include <wayfare/filter/particles.hpp>
#include <wayfare/filter/rbpf.hpp>
#include <wayfare/filter/sequential_update.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::tests {
namespace {

using Filter3 = Ekf<SE2d>;
using Row3 = Eigen::Matrix<double, 1, 3>;

Filter3 start_filter() {
  Eigen::Matrix3d p = Eigen::Vector3d(4.0, 1.0, 0.1).asDiagonal();
  p(0, 1) = p(1, 0) = 0.5;
  return {SE2d(1.0, 2.0, Angle::radians(0.3)), p};
}

void expect_unchanged(const Filter3& filter) {
  EXPECT_EQ(filter.state().minus(start_filter().state()).norm(), 0.0);
  EXPECT_EQ(filter.covariance(), start_filter().covariance());
}

ScalarUpdate<double> update(Filter3& filter, double innovation, const Row3& row, double variance) {
  return filter.update([&](const SE2d&) {
    return ScalarMeasurement<double, Row3>{innovation, row, variance};
  });
}

TEST(EkfAbuse, AMeasurementThatIsNoNumberChangesNothing) {
  const Row3 row(1.0, 0.0, 0.0);
  for (const double odd : {kNan, kInf, -kInf, kHuge, -kHuge}) {
    Filter3 filter = start_filter();
    EXPECT_FALSE(update(filter, odd, row, 1.0).accepted);
    Row3 odd_row = row;
    odd_row[1] = odd;
    EXPECT_FALSE(update(filter, 0.5, odd_row, 1.0).accepted) << odd;
    EXPECT_FALSE(update(filter, 0.5, odd * row, 1.0).accepted) << odd;
    if (odd != kHuge) {
      EXPECT_FALSE(update(filter, 0.5, row, odd).accepted) << odd;
    }
    const SparseRow<double, 2> sparse{{0, 2}, {1.0, odd}};
    EXPECT_FALSE(filter
                     .update([&](const SE2d&) {
                       return ScalarMeasurement<double, SparseRow<double, 2>>{0.5, sparse, 1.0};
                     })
                     .accepted);
    expect_unchanged(filter);
  }
}

TEST(EkfAbuse, AVarianceThatIsNotPositiveIsRejected) {
  Filter3 filter = start_filter();
  EXPECT_FALSE(update(filter, 0.5, Row3(1, 0, 0), -4.0).accepted);
  EXPECT_FALSE(update(filter, 0.5, Row3(1, 0, 0), -5.0).accepted);
  EXPECT_FALSE(update(filter, 0.5, Row3::Zero(), 0.0).accepted);
  expect_unchanged(filter);
  // Exact measurements leave no variance, however often they are repeated.
  for (int i = 0; i < 50; ++i) (void)update(filter, 0.0, Row3(1, 0, 0), 0.0);
  EXPECT_TRUE(filter.covariance().allFinite());
  EXPECT_NEAR(filter.covariance()(0, 0), 0.0, 1e-12);
  EXPECT_GT(filter.covariance()(1, 1), 0.5);
}

TEST(EkfAbuse, NoGateOfAnyKindLetsNaNIn) {
  for (const double gate : {0.0, kNan, kInf, kHuge}) {
    Filter3 filter = start_filter();
    const auto nan = [](const SE2d&) {
      return ScalarMeasurement<double, Row3>{kNan, Row3(1, 0, 0), 1.0};
    };
    EXPECT_FALSE(filter.update(nan, gate).accepted);
    EXPECT_FALSE(filter.update(nan, gate, false).accepted);
    expect_unchanged(filter);
  }
}

TEST(EkfAbuse, ABlockThatIsNoNumberChangesNothing) {
  using Two = Eigen::Vector2d;
  Eigen::Matrix<double, 2, 3> h = Eigen::Matrix<double, 2, 3>::Zero();
  h(0, 0) = h(1, 1) = 1.0;
  const Eigen::Matrix2d r = Eigen::Matrix2d::Identity();
  Filter3 filter = start_filter();
  for (const double odd : {kNan, kInf, -kInf, kHuge}) {
    EXPECT_FALSE(filter.update_block(Two(odd, 0.0), h, r)) << odd;
    EXPECT_FALSE(filter.update_block(Two(0.1, 0.0), Eigen::Matrix<double, 2, 3>(odd * h), r))
        << odd;
    if (odd != kHuge) {
      EXPECT_FALSE(filter.update_block(Two(0.1, 0.0), h, Eigen::Matrix2d(odd * r))) << odd;
    }
  }
  EXPECT_FALSE(filter.update_block(Two(0.1, 0.0), h, Eigen::Matrix2d(-9.0 * r)));
  EXPECT_FALSE(filter.update_block(Two(0.1, 0.0), h, r, kNan));
  EXPECT_FALSE(filter.update_block(Two(0.1, 0.0), h, r, -1.0));
  expect_unchanged(filter);
}

TEST(EkfAbuse, LanesThatAreRejectedKeepTheirState) {
  using Four = Pack<double, 4>;
  using State = Eigen::Matrix<Four, 2, 1>;
  State x;
  x << Four(1.0), Four(2.0);
  Ekf<State> filter(x, Eigen::Matrix<Four, 2, 2>::Identity());
  Four innovation(0.5), variance(1.0);
  for (int i = 0; i < 3; ++i) innovation.set(i, kNotFinite[static_cast<std::size_t>(i)]);
  Eigen::Matrix<Four, 1, 2> row;
  row << Four(1.0), Four(0.0);
  const auto said = filter.update([&](const State&) {
    return ScalarMeasurement<Four, Eigen::Matrix<Four, 1, 2>>{innovation, row, variance};
  });
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(said.accepted[i]);
    EXPECT_EQ(filter.state()[0][i], 1.0);
    EXPECT_EQ(filter.covariance()(0, 0)[i], 1.0);
  }
  EXPECT_TRUE(said.accepted[3]);
  EXPECT_EQ(filter.state()[0][3], 1.25);
  EXPECT_DOUBLE_EQ(filter.covariance()(0, 0)[3], 0.5);
}

TEST(EkfAbuse, LivesAsAValue) {
  expect_value_semantics(start_filter(), [](Filter3& f) {
    (void)update(f, 0.3, Row3(1, 1, 0), 0.5);
    return std::array<double, 4>{f.state().x(), f.state().heading().radians(), f.covariance()(0, 0),
                                 f.covariance()(1, 2)};
  });
}

TEST(SequentialAbuse, AnExactlyKnownNumberMeasuredExactlyStays) {
  SymmetricMatrix<double, 2> p;
  p(1, 1) = 3.0;
  std::array<double, 2> correction{};
  EXPECT_EQ(sequential_update(p, correction, IndexedRow<double, 0>{1.0}, 5.0, 0.0), 0.0);
  EXPECT_EQ(correction, (std::array<double, 2>{}));
  EXPECT_EQ(p.dense(), Eigen::Matrix2d(Eigen::Vector2d(0.0, 3.0).asDiagonal()));
  Eigen::Matrix2d dense = Eigen::Matrix2d::Zero();
  DenseCovariance<Eigen::Matrix2d> covariance{dense};
  Eigen::Vector2d moved = Eigen::Vector2d::Zero();
  sequential_update(covariance, moved, IndexedRow<double, 0, 1>{1.0, -1.0}, 5.0, 0.0);
  EXPECT_EQ(moved, Eigen::Vector2d::Zero());
  EXPECT_TRUE(dense.isZero(0.0));
}

TEST(CovarianceIntersectionAbuse, OfAnyScaleIsFiniteOrNothing) {
  Rng rng(5);
  for (int i = 0; i < 2000; ++i) {
    const auto scale = [&] { return std::pow(10.0, rng.uniform(-200.0, 200.0)); };
    Eigen::Matrix3d a;
    Eigen::Matrix<double, 2, 3> c;
    for (double& x : a.reshaped()) x = rng.normal();
    for (double& x : c.reshaped()) x = rng.normal();
    Eigen::Matrix3d p = scale() * (a * a.transpose() + 1e-3 * Eigen::Matrix3d::Identity());
    Eigen::Matrix2d r = scale() * Eigen::Matrix2d::Identity();
    Eigen::Vector2d z(rng.normal(), scale());
    c *= scale();
    if (rng.below(4) == 0) p(1, 1) = kNotFinite[rng.below(3)];
    if (rng.below(4) == 0) r(0, 0) = rng.below(2) == 0 ? 0.0 : kNotFinite[rng.below(3)];
    if (rng.below(4) == 0) z[0] = kNotFinite[rng.below(3)];
    const auto fused = covariance_intersection<3, 2>(p, c, r, z);
    if (!p.allFinite() || !r.allFinite() || !z.allFinite() || !(r(0, 0) > 0.0)) {
      ASSERT_FALSE(fused);
    }
    if (!fused) continue;
    ASSERT_TRUE(fused->correction.allFinite());
    ASSERT_TRUE(fused->covariance.allFinite());
    ASSERT_TRUE(fused->omega >= 0.0 && fused->omega < 1.0);
  }
}

TEST(GaussMarkovAbuse, StepsAndTimesFromZeroToInfinity) {
  for (const double dt : {0.0, kTiny, 1.0, 1e9, kHuge, kInf})
    for (const double tau : {1e-9, 1.0, 1e9, kHuge}) {
      const auto step = discretise_gauss_markov(2.0, tau, dt);
      EXPECT_TRUE(step.phi >= 0.0 && step.phi <= 1.0) << dt << ' ' << tau;
      EXPECT_TRUE(step.q >= 0.0 && step.q <= 4.0) << dt << ' ' << tau;
    }
  // Uncorrelated, and constant.
  EXPECT_EQ(discretise_gauss_markov(2.0, 0.0, 1.0).q, 4.0);
  EXPECT_EQ(discretise_gauss_markov(2.0, kInf, 1.0).phi, 1.0);
  EXPECT_EQ(discretise_clock(1.0, 1.0, 0.0).bias_variance, 0.0);
}

constexpr std::array kSchemes{Resampling::multinomial, Resampling::residual, Resampling::stratified,
                              Resampling::low_variance};

TEST(ParticlesAbuse, EmptyAndSingleSets) {
  Rng rng(1);
  EXPECT_EQ(log_sum_exp({}), -kInf);
  EXPECT_EQ(effective_sample_size({}), 0.0);
  EXPECT_TRUE(normalise({}).collapsed);
  for (const Resampling scheme : kSchemes) {
    EXPECT_EQ(resample({}, 3, scheme, rng), std::vector<ParticleIndex>(3, 0));
    for (const double w : {0.0, -kInf, kInf, kNan, kHuge, -kHuge}) {
      const std::array one{w};
      EXPECT_EQ(resample(one, 5, scheme, rng), std::vector<ParticleIndex>(5, 0));
      EXPECT_TRUE(resample(one, 0, scheme, rng).empty());
    }
  }
}

TEST(ParticlesAbuse, LogWeightsOfAnySizeAreDrawnInOrderAndOnlyWithWeight) {
  Rng rng(2);
  for (int run = 0; run < 1500; ++run) {
    std::vector<double> weights(1 + rng.below(20));
    for (double& w : weights) {
      constexpr std::array kOdd{kNan, kInf, -kInf, kHuge, -kHuge, 1e308, -1e308, 0.0};
      w = rng.below(2) == 0 ? kOdd[rng.below(kOdd.size())] : rng.uniform(-800.0, 800.0);
    }
    const double max = max_log_weight(weights);
    for (const Resampling scheme : kSchemes) {
      const std::size_t count = rng.below(50);
      const auto drawn = resample(weights, count, scheme, rng);
      ASSERT_EQ(drawn.size(), count);
      ASSERT_TRUE(std::is_sorted(drawn.begin(), drawn.end()));
      for (const ParticleIndex i : drawn) {
        ASSERT_LT(i, weights.size());
        if (std::isfinite(max)) {
          ASSERT_GT(relative_weight(weights[i], max), 0.0) << run;
        }
      }
    }
    const double effective = effective_sample_size(weights);
    ASSERT_TRUE(std::isfinite(max) ? effective >= 1.0 - 1e-12 : effective == 0.0);
    ASSERT_LE(effective, static_cast<double>(weights.size()) + 1e-9);
    const Normalisation said = normalise(weights);
    ASSERT_EQ(said.collapsed, !std::isfinite(max));
    double sum = 0.0;
    for (const double w : weights) sum += std::exp(w);
    ASSERT_NEAR(sum, 1.0, 1e-9) << run;
  }
}

TEST(RbpfDeathTest, NeedsParticles) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(Rbpf<int>(0, StampedPose{}, 0, 1), "particles");
}

TEST(FiltersAbuse, TwoThreadsEstimateTheSame) {
  const auto both = in_two_threads([](int) {
    Rng rng(3);
    Filter3 filter = start_filter();
    Rbpf<int> particles(20, StampedPose{}, 0, 5);
    for (int i = 0; i < 200; ++i) {
      (void)update(filter, rng.normal(), Row3(rng.normal(), 1.0, 0.0), 0.5);
      (void)particles.update(LogTime::from_seconds(i), [](auto& p, Rng& r, std::size_t) {
        p.pose = p.pose * SE2d(r.normal(), 0.0, Angle{});
        return -p.pose.x() * p.pose.x();
      });
      particles.resample_below();
    }
    return std::vector<double>{filter.state().x(), filter.covariance()(0, 0),
                               particles.particles()[particles.best()].pose.x(),
                               static_cast<double>(particles.stored_poses())};
  });
  EXPECT_EQ(both[0], both[1]);
}

}  // namespace
}  // namespace wayfare::tests
