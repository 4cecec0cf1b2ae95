#include <wayfare/filter/measurement.hpp>

#include <cmath>

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <wayfare/filter/ekf.hpp>
#include <wayfare/testing/state_laws.hpp>

#include "filter/cart.hpp"

namespace wayfare {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using testing::StateLaws;
using tests::Drift, tests::One, tests::Pose, tests::Scale;
using Cart = State<Pose, Drift, Scale>;

/// The position of a beacon in the cart's frame, scaled.
template <class Kind>
struct Beacon {
  using Blocks = BlockList<Scale, Pose>;
  using Jacobians = Kind;
  static constexpr int kDim = 2;
  Vector2d beacon_m{3.0, -1.0}, measured_m{2.0, 0.5};
  Matrix2d covariance{{0.2, 0.05}, {0.05, 0.1}};
  template <class T>
  Eigen::Matrix<T, 2, 1> error(const One<T>& scale, const SE2<T>& pose) const {
    return (T(1) + scale[0]) * (pose.inverse() * Eigen::Matrix<T, 2, 1>(beacon_m.cast<T>())) -
           measured_m.cast<T>();
  }
};
struct BeaconByHand : Beacon<NumericJacobians> {
  Vector2d linearise(const One<double>& scale, const SE2d& pose,
                     JacobianBlocks<Vector2d, One<double>, SE2d>& by) const {
    const Vector2d seen = pose.inverse() * beacon_m;
    std::get<0>(by) = seen;
    std::get<1>(by) << -Matrix2d::Identity(), Vector2d(seen.y(), -seen.x());
    std::get<1>(by) *= 1.0 + scale[0];
    return error(scale, pose);
  }
};
/// A scalar, of the whole state, in standard deviations.
struct Compass {
  static constexpr int kDim = 1;
  One<double> error(const Cart& x) const {
    return One<double>((x.get<Pose>().heading().radians() - 0.4) / 0.05);
  }
};

TEST(Measurement, SatisfiesTheLawsWithJacobiansOfEveryKind) {
  StateLaws<Cart> laws;
  laws.check_measurement(Beacon<AutomaticJacobians>{});
  laws.check_measurement(Beacon<NumericJacobians>{});
  laws.check_measurement(BeaconByHand{});
  laws.scale = 0.3;  // the compass is not wrapped
  laws.check_measurement(Compass{});
}

// A vector update beside the gain written down, K = P Hᵀ (H P Hᵀ + R)⁻¹, with the columns of H
// where the state has the blocks and not where the measurement lists them.
TEST(Measurement, UpdatesAsTheDenseGain) {
  SquareOf<Cart> a;
  for (int i = 0; i < a.size(); ++i) a.reshaped()[i] = std::sin(1.0 + i * i);
  const SquareOf<Cart> p = 0.1 * (a * a.transpose() + SquareOf<Cart>::Identity());
  Cart x;
  x.get<Pose>() = SE2d(0.5, -0.2, Angle::radians(0.3));
  x.get<Scale>()[0] = 0.1;
  Ekf<Cart> filter(x, p);
  const BeaconByHand beacon;
  JacobianBlocks<Vector2d, One<double>, SE2d> by;
  const Vector2d innovation = -beacon.linearise(x.get<Scale>(), x.get<Pose>(), by);
  Eigen::Matrix<double, 2, 6> h = Eigen::Matrix<double, 2, 6>::Zero();
  h.leftCols<3>() = std::get<1>(by);
  h.col(5) = std::get<0>(by);
  const Eigen::Matrix<double, 6, 2> gain =
      p * h.transpose() * (h * p * h.transpose() + beacon.covariance).inverse();
  ASSERT_TRUE(filter.update(beacon).accepted);
  EXPECT_LT((filter.state().minus(x.plus(gain * innovation))).norm(), 1e-12);
  const SquareOf<Cart> after = p - gain * h * p;
  EXPECT_LT((filter.covariance() - after).norm(), 1e-12 * p.norm());
}

TEST(Measurement, OutlierIsRejectedByItsNormalisedInnovationSquared) {
  Ekf<Cart> filter(Cart{}, 0.01 * SquareOf<Cart>::Identity());
  Beacon<AutomaticJacobians> far;
  far.measured_m = {100.0, 0.0};
  const auto u = filter.update(far, 13.8);
  EXPECT_FALSE(u.accepted);
  EXPECT_NEAR(u.nis, u.innovation.dot(u.covariance.inverse() * u.innovation), 1e-9 * u.nis);
  EXPECT_EQ(filter.covariance(), SquareOf<Cart>(0.01 * SquareOf<Cart>::Identity()));
}

}  // namespace
}  // namespace wayfare
