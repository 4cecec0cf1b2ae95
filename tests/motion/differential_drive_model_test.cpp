#include <wayfare/motion/differential_drive_model.hpp>

#include <numbers>
#include <vector>

#include <Eigen/LU>

#include <gtest/gtest.h>

#include <wayfare/testing/filter_laws.hpp>

namespace wayfare {
namespace {

struct Drive {
  double along_m, turn_rad;
};
// Straight, nearly straight on both sides of the series' limit, turning on the spot, backwards, a
// whole turn and more than half a turn.
const std::vector<Drive> kDrives = {
    {0.3, 0.0}, {0.3, 1e-9},  {0.3, -1e-4}, {0.2, 0.7},
    {0.0, 1.1}, {-0.4, -0.6}, {1.0, 3.5},   {0.5, 2.0 * std::numbers::pi},
    {0.0, 0.0}};

// Circle of radius d/θ about a point to the left: end (r sin θ, r (1 − cos θ)).
void expect_arc(const SE2d& end, const Drive& drive) {
  const auto [d, turn] = drive;
  if (std::abs(turn) < 1e-6) {
    EXPECT_NEAR(end.x(), d, 1e-12);
    EXPECT_NEAR(end.y(), d * turn / 2.0, 1e-12);
  } else {
    EXPECT_NEAR(end.x(), d / turn * std::sin(turn), 1e-9);
    EXPECT_NEAR(end.y(), d / turn * (1.0 - std::cos(turn)), 1e-9);
  }
  EXPECT_NEAR(wrap_to_pi(end.heading().radians() - turn), 0.0, 1e-12);
}

TEST(DifferentialDriveModel, FollowsTheArc) {
  const DifferentialDriveModel model{.wheel_base_m = 0.5};
  for (const Drive& d : kDrives) {
    const double half = 0.5 * d.turn_rad * model.wheel_base_m;
    expect_arc(model(d.along_m - half, d.along_m + half).mean, d);
  }
}

TEST(GyroMotion, FollowsTheArc) {
  const GyroMotion model;
  for (const Drive& d : kDrives) expect_arc(model(d.along_m, d.turn_rad / 0.2, 0.2).mean, d);
}

// ∂(exp of the twist)/∂inputs by central differences; the error of those is (step²/6)·f‴, below
// 1e-9 here, and rounding 1e-16/step = 1e-11.
template <class F>
void expect_jacobian(const F& increment, const Eigen::Vector2d& at, const InputJacobian& analytic) {
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d step = 1e-5 * Eigen::Vector2d::Unit(i);
    const Eigen::Vector3d numeric = increment(at + step).minus(increment(at - step)) / 2e-5;
    EXPECT_LE((analytic.by_inputs.col(i) - numeric).norm(), 1e-8)
        << "input " << i << " at " << at.transpose() << "\n"
        << analytic.by_inputs.col(i).transpose() << " against " << numeric.transpose();
  }
}

TEST(DifferentialDriveModel, JacobianMatchesFiniteDifferences) {
  const DifferentialDriveModel model;
  for (const Drive& d : kDrives) {
    const Eigen::Vector2d at(d.along_m - d.turn_rad * 0.2, d.along_m + d.turn_rad * 0.2);
    expect_jacobian([&](const Eigen::Vector2d& w) { return model(w[0], w[1]).mean; }, at,
                    model.linearised(at[0], at[1]));
  }
}

TEST(GyroMotion, JacobianMatchesFiniteDifferences) {
  const GyroMotion model;
  const double dt = 0.25;
  for (const Drive& d : kDrives) {
    const Eigen::Vector2d at(d.along_m, d.turn_rad);
    expect_jacobian([&](const Eigen::Vector2d& u) { return model(u[0], u[1] / dt, dt).mean; }, at,
                    model.linearised(at[0], at[1] / dt, dt));
  }
}

TEST(DifferentialDriveModel, CovarianceMatchesSimulatedSlip) {
  const DifferentialDriveModel model{.slip_m_per_sqrt_m = 0.01, .scale = 0.005, .ground = {}};
  const double left = 0.4, right = 0.5;
  const Gaussian<SE2d> motion = model(left, right);
  testing::expect_covariance(motion.covariance);
  // Draws from the model: an error of each wheel, then an unmeasured slide.
  Rng rng(7);
  const Eigen::Vector2d sigma(std::sqrt(1e-4 * left + std::pow(0.005 * left, 2)),
                              std::sqrt(1e-4 * right + std::pow(0.005 * right, 2)));
  const double along = 0.45, turn = 0.25;
  std::vector<SE2d> samples;
  for (int i = 0; i < 40000; ++i) {
    const double l = left + sigma[0] * rng.normal(), r = right + sigma[1] * rng.normal();
    const Eigen::Vector3d slip(1e-5 * rng.normal(), std::sqrt(1e-10 + 4e-6 * along) * rng.normal(),
                               std::sqrt(1e-10 + 1e-4 * turn) * rng.normal());
    samples.push_back(SE2d::exp(Eigen::Vector3d((l + r) / 2, 0, (r - l) / 0.4)).plus(slip));
  }
  // The heading's sigma is 0.024 rad over a distance of 0.45 m: second-order terms of ½·0.45·0.024²
  // = 1.3e-4 m against a sideways sigma of 5.6e-3 m.
  testing::expect_samples_follow(motion, samples, 6.0, 0.025);
}

TEST(DifferentialDriveModel, VariancesOfStepsAddUp) {
  // Straight motion in one step and in ten: slip is a random walk, so the wheels' part is the same.
  const DifferentialDriveModel model{.ground = {0.0, 0.0, 0.0, 0.0}};
  Gaussian<SE2d> pieces{SE2d::identity(), Eigen::Matrix3d::Zero()};
  for (int i = 0; i < 10; ++i) pieces = compose(pieces, model(0.1, 0.1));
  const Gaussian<SE2d> whole = model(1.0, 1.0);
  EXPECT_NEAR(pieces.covariance(0, 0), whole.covariance(0, 0), 1e-15);
  EXPECT_NEAR(pieces.covariance(2, 2), whole.covariance(2, 2), 1e-15);
}

TEST(GyroMotion, AtRestOnlyTheGyrosNoiseRemains) {
  const GyroMotion model{.ground = {0.0, 0.0, 0.0, 0.0}};
  const Gaussian<SE2d> rest = model(0.0, 0.0, 4.0);
  EXPECT_EQ(rest.covariance(0, 0), 0.0);
  EXPECT_EQ(rest.covariance(1, 1), 0.0);
  EXPECT_NEAR(rest.covariance(2, 2), 1e-6 * 4.0 + std::pow(0.0005 * 4.0, 2), 1e-15);
}

TEST(Fuse, WeighsByInverseCovarianceAcrossTheWrap) {
  // ±π ∓ 0.1 rad: the headings are on either side of ±π, 0.2 rad apart.
  Gaussian<SE2d> a{SE2d(1.0, 0.0, Angle::radians(std::numbers::pi - 0.1)), {}};
  Gaussian<SE2d> b{SE2d(1.0, 0.0, Angle::radians(-std::numbers::pi + 0.1)), {}};
  a.covariance = Eigen::Vector3d(1.0, 1.0, 1.0).asDiagonal();
  b.covariance = Eigen::Vector3d(1.0, 1.0, 3.0).asDiagonal();
  const auto both = fuse(a, b);
  ASSERT_TRUE(both);
  EXPECT_NEAR(both->covariance(2, 2), 0.75, 1e-12);
  EXPECT_NEAR(both->mean.heading().radians(), std::numbers::pi - 0.05, 1e-12);
  EXPECT_NEAR(both->mean.x(), 1.0, 1e-12);
}

//! [fuse]
TEST(Fuse, SumsInformationAndKeepsEqualMeans) {
  const Gaussian<SE2d> wheels = DifferentialDriveModel{}(0.20, 0.24);
  const Gaussian<SE2d> gyro = GyroMotion{}(0.22, 0.5, 0.2);
  const auto both = fuse(wheels, gyro);
  ASSERT_TRUE(both);
  const Eigen::Matrix3d sum = wheels.covariance.inverse() + gyro.covariance.inverse();
  EXPECT_TRUE((both->covariance * sum).isIdentity(1e-9)) << both->covariance * sum;
  EXPECT_LE(both->mean.minus(wheels.mean).norm(), 1e-12);  // both rotated by 0.1 rad
}
//! [fuse]

TEST(Fuse, NamesNonFiniteInput) {
  const auto both = fuse(DifferentialDriveModel{}(0.2, 0.2), GyroMotion{}(0.2, std::nan(""), 0.1));
  ASSERT_FALSE(both);
  EXPECT_EQ(both.error().code, ErrorCode::numerical);
}

TEST(MotionSampler, DrawsFollowTheGaussian) {
  const Gaussian<SE2d> motion = DifferentialDriveModel{}(0.5, 0.8);
  const MotionSampler draw(motion);
  Rng rng(3);
  std::vector<SE2d> samples;
  for (int i = 0; i < 20000; ++i) samples.push_back(draw(rng));
  testing::expect_samples_follow(motion, samples);
}

TEST(MotionSampler, DrawsOfASingularCovarianceStayInItsRange) {
  Gaussian<SE2d> motion{SE2d(1.0, 2.0, 0.5_rad), Eigen::Matrix3d::Zero()};
  motion.covariance(2, 2) = 0.01;
  const MotionSampler draw(motion);
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const SE2d x = draw(rng);
    EXPECT_EQ(x.translation(), motion.mean.translation());
    EXPECT_NE(x.heading().radians(), 0.5);
  }
}

}  // namespace
}  // namespace wayfare
