#include <wayfare/slam/detail/carrier_filter.hpp>

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <wayfare/sim/walks.hpp>
#include <wayfare/testing/detail/positive_definite.hpp>

#include "filter/numeric_jacobian.hpp"

namespace wayfare {
namespace {

using S = CarrierState;

S some_state() {
  S x;
  x.position_m << 3, -2, 0.1;
  x.velocity_mps << 1, 0.5, -0.2;
  x.q_map_body = SO3d::exp(Eigen::Vector3d(0.2, -0.3, 2.0));
  x.gyro_bias_radps << 0.01, -0.02, 0.015;
  x.accel_bias_mps2 << 0.1, -0.05, 0.2;
  return x;
}

TEST(CarrierMotion, JacobianEqualsTheNumericDerivative) {
  const CarrierModel model;
  ImuInterval u;
  u.begin_rate_radps << 0.5, -1.0, 2.0;
  u.end_rate_radps << 0.6, -0.8, 2.1;
  u.begin_force_mps2 << 1.0, -2.0, 9.0;
  u.end_force_mps2 << 1.5, -1.0, 10.0;
  u.dt_s = 0.01;
  const auto numeric = tests::numeric_jacobian([&](const S& x) { return model(x, u).state; },
                                               some_state(), S::Tangent::Constant(1e-5));
  // Bound: second-order terms of the step.
  EXPECT_LT((model(some_state(), u).phi - numeric).cwiseAbs().maxCoeff(), 2e-5);
}

TEST(CarrierMotion, PlanarJacobianEqualsTheNumericDerivative) {
  const S x = some_state();
  const auto c = x.planar_jacobian();
  for (int i = 0; i < 3; ++i) {
    const auto element = [&](const S& y) {
      const SE2d p = y.planar();
      return i < 2 ? p.translation()[i]
                   : (p.rotation() * x.planar().rotation().inverse()).angle().radians();
    };
    const auto row = tests::numeric_gradient(element, x, S::Tangent::Constant(1e-5));
    EXPECT_LT((c.row(i) - row).cwiseAbs().maxCoeff(), 1e-8) << i;
  }
}

ImuSample still(double t, const SO3d& q_map_body = {}) {
  return {LogTime::from_seconds(t), Eigen::Vector3d::Zero(),
          q_map_body.inverse() * Eigen::Vector3d(0, 0, CarrierModel::kGravity_mps2)};
}

CarrierFilter standing(double seconds, const SO3d& q_map_body = {}) {
  CarrierFilter filter;
  for (int i = 0; i <= 100 * seconds; ++i) filter.add(still(0.01 * i, q_map_body));
  return filter;
}

TEST(CarrierFilter, StartsLevelAndStaysAtRest) {
  const SO3d tilted = SO3d::exp(Eigen::Vector3d(0.1, -0.2, 0.0));
  const CarrierFilter filter = standing(5, tilted);
  EXPECT_TRUE(filter.at_rest());
  EXPECT_LT((filter.q_level_body().inverse() * Eigen::Vector3d::UnitZ() -
             tilted.inverse() * Eigen::Vector3d::UnitZ())
                .norm(),
            1e-6);
  EXPECT_LT(filter.state().velocity_mps.norm(), 1e-6);
  EXPECT_LT(std::sqrt(filter.covariance()(S::kVelocity, S::kVelocity)), 0.03);
}

TEST(CarrierFilter, PlacingKeepsTheLevel) {
  CarrierFilter filter = standing(3, SO3d::exp(Eigen::Vector3d(0.1, -0.2, 0.0)));
  EXPECT_FALSE(filter.placed());
  const SO3d level = filter.q_level_body();
  const SE2d place(4, -1, Angle::degrees(120));
  filter.place(place, 0.05, Angle::degrees(2));
  EXPECT_TRUE(filter.placed());
  EXPECT_LT(filter.planar().minus(place).norm(), 1e-12);
  EXPECT_LT((filter.q_level_body().inverse() * level).log().norm(), 1e-12);
  const Eigen::Matrix3d p = filter.planar_covariance();
  EXPECT_NEAR(std::sqrt(p(0, 0)), 0.05, 1e-9);
  EXPECT_NEAR(p(2, 2), std::pow(Angle::degrees(2).radians(), 2), 0.1 * p(2, 2));
  EXPECT_GT(testing::least_pivot(filter.covariance()), 0);
}

// P⁺⁻¹ = (1 − ω) P⁻¹ + ω Cᵀ R⁻¹ C, and the information vectors likewise (Julier and Uhlmann 1997).
TEST(CarrierFilter, FusesByCovarianceIntersection) {
  CarrierFilter filter = standing(3, SO3d::exp(Eigen::Vector3d(0.1, -0.2, 0.0)));
  filter.place(SE2d(1, 2, Angle::degrees(30)), 0.3, Angle::degrees(5));
  const S before = filter.state();
  const CarrierFilter::Square p = filter.covariance();
  const auto c = before.planar_jacobian();
  const Eigen::Matrix3d r =
      Eigen::Vector3d(1e-4, 1e-4, 1e-5).asDiagonal();  // invariant under rotation
  const auto omega = filter.fuse(SE2d(1.1, 1.9, Angle::degrees(31)), r);
  ASSERT_TRUE(omega);
  EXPECT_GT(*omega, 0.0);
  const CarrierFilter::Square want =
      ((1 - *omega) * p.inverse() + *omega * c.transpose() * r.inverse() * c).inverse();
  // The biases are bounded by their initial variance.
  const CarrierFilter::Square off = filter.covariance() - want;
  EXPECT_LT(off.topLeftCorner(9, 9).norm(), 1e-6 * want.norm());
  const Eigen::Vector3d z(0.1, -0.1, Angle::degrees(1).radians());
  const S::Tangent moved = *omega * want * c.transpose() * r.inverse() * z;
  EXPECT_LT((filter.state().minus(before) - moved).norm(), 1e-6 * moved.norm());
}

// One match reported a hundred times: with covariance intersection it counts once, while as
// independent measurements it makes the filter ten times as certain.
TEST(CarrierFilter, ARepeatedMatchAddsNoInformation) {
  const double sigma = 0.02;
  const Eigen::Matrix3d r = Eigen::Vector3d(sigma * sigma, sigma * sigma, 1e-4).asDiagonal();
  const auto after = [&](bool independent) {
    CarrierFilterParameters p;
    p.independent_matches = independent;
    CarrierFilter filter(p);
    filter.add(still(0.0));
    filter.place(SE2d(), 0.5, Angle::degrees(5));
    for (int i = 0; i < 100; ++i) filter.fuse(SE2d(0.02, 0, Angle()), r);
    return std::sqrt(filter.planar_covariance()(0, 0));
  };
  EXPECT_GE(after(false), sigma);
  EXPECT_LT(after(true), 0.2 * sigma);
}

struct Followed {
  double tilt_deg = 0.0, worst_sigmas = 0.0, pose_nees = 0.0;
  int matches = 0;
};

/// Matches with correlated errors: 2 cm and 0.3° with a correlation time of 5 s, as from an
/// inaccurate map.
Followed follow_with_lasting_errors(std::uint64_t seed, bool independent) {
  const sim::HeadWalk head({{0, 0}, {10, 0}, {10, 8}, {0, 8}}, {}, Rng(seed));
  Rng rng(seed + 100);
  const double sigma = 0.02, turn = Angle::degrees(0.3).radians(), kept = std::exp(-0.18 / 5);
  Eigen::Vector3d off = sigma * Eigen::Vector3d(rng.normal(), rng.normal(), 0);
  CarrierFilterParameters p;
  p.independent_matches = independent;
  CarrierFilter filter(p);
  Followed f;
  double next = 1.0, tilt2 = 0.0;
  for (const MargSample& s : head.unit(100, {.accel_bias_mps2 = 0.03}, rng)) {
    filter.add({s.time, s.angular_rate_radps, s.specific_force_mps2});
    if (s.time.seconds() < next) continue;
    next += 0.18;
    const auto pose = head.at(s.time.seconds());
    S truth;
    truth.q_map_body = pose.q_world_head;
    truth.position_m = pose.position_m;
    const SE2d there = truth.planar();
    const Eigen::Vector3d scale(sigma, sigma, turn);
    for (int i = 0; i < 3; ++i)
      off[i] = kept * off[i] + std::sqrt(1 - kept * kept) * scale[i] * rng.normal();
    const SE2d match(there.translation() + off.head<2>(),
                     there.rotation() * SO2d(Angle::radians(off[2])));
    if (!filter.placed()) filter.place(match, sigma, Angle::degrees(0.3));
    EXPECT_TRUE(filter.fuse(match, scale.cwiseAbs2().asDiagonal()));
    const Eigen::Vector3d up = pose.q_world_head.inverse() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d u = filter.state().q_map_body.inverse() * Eigen::Vector3d::UnitZ();
    tilt2 += (up - u).squaredNorm();
    const Eigen::Vector3d e = there.minus(filter.planar());
    const Eigen::Matrix3d p_pose = filter.planar_covariance();
    f.worst_sigmas =
        std::max(f.worst_sigmas, e.head<2>().norm() / std::sqrt(p_pose(0, 0) + p_pose(1, 1)));
    f.pose_nees += e.dot(p_pose.inverse() * e) / 3;
    ++f.matches;
  }
  f.tilt_deg = std::sqrt(tilt2 / f.matches) * 180 / std::numbers::pi;
  f.pose_nees /= f.matches;
  return f;
}

TEST(CarrierFilter, IsConsistentWithCorrelatedErrors) {
  double intersected = 0.0, independent = 0.0;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Followed f = follow_with_lasting_errors(seed, false);
    EXPECT_GT(f.matches, 100);
    EXPECT_LT(f.tilt_deg, 1.0);
    EXPECT_LT(f.worst_sigmas, 3.0);
    intersected += f.pose_nees / 3;
    independent += follow_with_lasting_errors(seed, true).pose_nees / 3;
  }
  EXPECT_LT(intersected, 1.0);
  EXPECT_GT(independent, 2.0);
}

TEST(CarrierFilter, RefusesInvalidSamples) {
  CarrierFilter filter;
  ImuSample fall = still(0.0);
  fall.specific_force_mps2.setZero();
  EXPECT_EQ(filter.add(fall), UpdateStatus::waiting);
  EXPECT_FALSE(filter.covers(LogTime::from_seconds(0)));
  EXPECT_EQ(filter.add(still(0.1)), UpdateStatus::used);
  const S before = filter.state();
  EXPECT_EQ(filter.add(still(0.1)), UpdateStatus::late);
  ImuSample nan = still(0.2);
  nan.angular_rate_radps[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(filter.add(nan), UpdateStatus::missing);
  EXPECT_TRUE(filter.state().minus(before).isZero(0));
  Eigen::Matrix3d bad = Eigen::Matrix3d::Identity();
  bad(1, 1) = -1;
  EXPECT_FALSE(filter.fuse(SE2d(), bad));
  EXPECT_TRUE(filter.state().minus(before).isZero(0));
}

TEST(CarrierFilter, RestartsAfterAGapAndWhenTheLevelIsLost) {
  CarrierFilter filter = standing(3);
  filter.place(SE2d(5, 0, Angle::degrees(90)), 0.05, Angle::degrees(1));
  EXPECT_EQ(filter.starts(), 1U);
  EXPECT_FALSE(filter.covers(LogTime::from_seconds(3.5)));
  filter.add(still(4.0));
  EXPECT_EQ(filter.starts(), 2U);
  EXPECT_FALSE(filter.placed());
  EXPECT_NEAR(filter.planar().heading().degrees(), 90, 1e-9);
  // On its side without measured rotation: the gyro missed it.
  const SO3d side = SO3d::exp(Eigen::Vector3d(std::numbers::pi / 2, 0, 0));
  for (int i = 1; i < 300; ++i) filter.add(still(4.0 + 0.01 * i, side));
  EXPECT_EQ(filter.starts(), 3U);
  EXPECT_LT((filter.q_level_body().inverse() * Eigen::Vector3d::UnitZ() -
             side.inverse() * Eigen::Vector3d::UnitZ())
                .norm(),
            0.05);
  EXPECT_GT(testing::least_pivot(filter.covariance()), 0);
}

}  // namespace
}  // namespace wayfare
