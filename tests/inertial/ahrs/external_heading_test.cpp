// External headings: the filter's algebra against a dense filter with a cloned past state, and
// consistency in simulation.

#include <wayfare/inertial/detail/external_heading.hpp>

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/inertial/ahrs.hpp>
#include "core/at.hpp"
#include "motion.hpp"

namespace wayfare {
namespace {

using testing::kDegree;
using testing::Motion;
using testing::MotionOptions;
using tests::at;
using Filter = AhrsFilter<double>;

TEST(AxisHeading, RowIsTheNumericDerivative) {
  Rng rng(1);
  for (int trial = 0; trial < 50; ++trial) {
    const SO3d q = SO3d::exp(testing::normal3(rng, 1.0));
    const Eigen::Vector3d axis = testing::normal3(rng, 1.0).normalized();
    const auto here = AxisHeading<double>::of(q.matrix(), axis);
    if (!here.level) continue;
    for (int i = 0; i < 3; ++i) {
      constexpr double h = 1e-6;
      const Eigen::Vector3d d = h * Eigen::Vector3d::Unit(i);
      const double ahead = AxisHeading<double>::of((SO3d::exp(d) * q).matrix(), axis).radians;
      const double behind = AxisHeading<double>::of((SO3d::exp(-d) * q).matrix(), axis).radians;
      EXPECT_NEAR(wrap_to_pi(ahead - behind) / (2 * h), here.row[i],
                  1e-6 * (1 + std::abs(here.row[i])));
    }
  }
  EXPECT_FALSE(
      AxisHeading<double>::of(Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitZ()).level);
}

/// Nine states and, as the tenth, the cloned heading error at the time of the fix, dense.
struct Cloned {
  Eigen::Matrix<double, 10, 10> p = Eigen::Matrix<double, 10, 10>::Zero();

  void turn(const Eigen::Matrix3d& r, double dt, double angle, double bias) {
    Eigen::Matrix<double, 10, 10> f = Eigen::Matrix<double, 10, 10>::Identity();
    f.block<3, 3>(0, 3) = -r * dt;
    p = f * p * f.transpose();
    p.diagonal().head<3>().array() += angle;
    p.diagonal().segment<3>(3).array() += bias;
  }
};

// One second of rotation about the vertical after the time of the fix: without bias noise the bias
// row and the shared noise are exact.
TEST(ExternalHeading, DelayedFixEqualsStochasticCloning) {
  for (const double bias_noise : {0.0, 1e-9}) {
    Rng rng(3);
    Eigen::Matrix<double, 9, 9> a;
    for (double& x : a.reshaped()) x = rng.normal();
    Cloned dense;
    dense.p.topLeftCorner<9, 9>() = 1e-3 * (a * a.transpose() + decltype(a)::Identity());
    AhrsParameters parameters;
    parameters.heading_history_s = 2.0;
    ExternalHeading<double> external(parameters);
    Filter f;
    f.set_attitude(SO3d::exp({0.0, 0.0, 0.4}));
    for (int i = 0; i < 9; ++i)
      for (int j = 0; j < 9; ++j) f.covariance()(i, j) = dense.p(i, j);
    constexpr double dt = 0.01, noise = 2e-5;
    double heading = 0.0;
    for (int i = 0; i < 150; ++i) {
      const auto begun = external.begin_turn(f, dt, noise);
      dense.turn(f.rotation(), dt, noise, bias_noise);
      f.turn({0.0, 0.0, 1.5}, dt, noise, bias_noise);
      external.end_turn(at(0.01 * i), begun, f);
      if (i != 49) continue;
      const auto then = external.now(f);
      heading = then.radians + 0.03;
      Eigen::Matrix<double, 10, 1> h = Eigen::Matrix<double, 10, 1>::Zero();
      h.head<3>() = then.row;
      dense.p.col(9).head<9>() = (dense.p * h).head<9>();
      dense.p.row(9).head<9>() = dense.p.col(9).head<9>().transpose();
      dense.p(9, 9) = h.dot(dense.p * h);
    }
    const double variance = 4e-4;
    const Eigen::Matrix<double, 10, 1> gain = dense.p.col(9) / (dense.p(9, 9) + variance);
    const Eigen::Matrix<double, 9, 9> expected =
        (dense.p - gain * dense.p.row(9)).topLeftCorner<9, 9>();
    const SO3d before = f.q_enu_body();
    const auto outcome = external.update(
        f, {at(0.49), Angle::radians(std::numbers::pi / 2 - heading), variance}, true);
    EXPECT_EQ(outcome.status, UpdateStatus::used);
    // The row neglects the bias noise in between: 1e-9 of 1e-3.
    const double tolerance = bias_noise > 0 ? 1e-4 : 1e-9;
    EXPECT_LT((f.covariance().dense() - expected).norm(), tolerance * expected.norm());
    const Eigen::Vector3d moved = (f.q_enu_body() * before.inverse()).log();
    EXPECT_LT((moved - gain.head<3>() * 0.03).norm(), (tolerance + 1e-6) * moved.norm());
    EXPECT_LT((f.bias() - gain.segment<3>(3) * 0.03).norm(), (tolerance + 1e-6) * f.bias().norm());
  }
}

/// A motion with exactly the parameters' noise, and delayed headings of it.
struct Scenario {
  AhrsParameters parameters;
  MotionOptions motion;
  double delay_s = 0.15, sigma = 1.0 * kDegree, spacing_s = 1.0;
  bool stamped_late = false;  // with their time of arrival
};

Scenario scenario(std::uint64_t seed) {
  Scenario t;
  AhrsParameters& p = t.parameters;
  p.use_magnetometer = false;
  p.heading_history_s = 1.0;
  p.rate_noise = 0.2 * kDegree;
  p.rate_scale_noise = 0.0;
  p.bias_walk = 1e-6;
  p.bias_sigma = 0.5 * kDegree;
  p.velocity_time_s = 0.2;
  p.velocity_density = 0.3;
  MotionOptions& o = t.motion;
  o.rate_hz = 50.0;
  o.duration_s = 120.0;
  o.turn_radps = 0.2;
  o.velocity_time_s = 0.2;
  o.velocity_sigma = 0.3 / std::sqrt(0.4);
  o.rate_density = p.rate_noise;
  o.force_density = p.force_noise;
  o.start = SO3d::exp({0.02, -0.03, 0.7});
  o.seed = seed;
  Rng rng(seed + 100);
  o.bias_radps = testing::normal3(rng, p.bias_sigma);
  o.rest_s = 0.05;
  return t;
}

double heading_of(const SO3d& q) {
  return AxisHeading<double>::of(q.matrix(), Eigen::Vector3d::UnitX()).radians;
}

/// Calls `after(ahrs, sample, truth, status of the fix or none)`.
template <class After>
Ahrs<frame::Enu> run(const Scenario& t, After after) {
  const Motion motion = testing::simulate(t.motion);
  Ahrs<frame::Enu> ahrs(t.parameters);
  Rng rng(t.motion.seed + 500);
  const auto late = static_cast<std::size_t>(std::lround(t.delay_s * t.motion.rate_hz));
  const auto every = static_cast<std::size_t>(std::lround(t.spacing_s * t.motion.rate_hz));
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    ahrs.add(motion.samples[i]);
    std::optional<UpdateStatus> status;
    if (i > late && i % every == 0) {
      const double heading = heading_of(motion.q_enu_body[i - late]) + t.sigma * rng.normal();
      const LogTime time = motion.samples[t.stamped_late ? i : i - late].time;
      status = ahrs.add_heading(
          {time, Angle::radians(std::numbers::pi / 2 - heading), t.sigma * t.sigma});
    }
    after(ahrs, motion.samples[i], motion.q_enu_body[i], status);
  }
  return ahrs;
}

TEST(ExternalHeading, ErrorsAndInnovationsHaveTheirVariance) {
  double nis = 0.0, heading = 0.0, bias = 0.0;
  int n_nis = 0, n = 0, refused = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Scenario t = scenario(seed);
    int count = 0;
    run(t, [&](const auto& ahrs, const MargSample&, const SO3d& truth, auto status) {
      if (!status) return;
      refused += *status == UpdateStatus::disturbed ? 1 : 0;
      if (++count < 10) return;
      nis += ahrs.nis().external;
      ++n_nis;
      if (count % 20 != 0) return;
      const double off = wrap_to_pi(heading_of(ahrs.q_world_body()) - heading_of(truth));
      heading += off * off / ahrs.world_covariance()(2, 2);
      const double b = ahrs.gyro_bias_radps().z() - t.motion.bias_radps.z();
      bias += b * b / (ahrs.gyro_bias_sigma_radps().z() * ahrs.gyro_bias_sigma_radps().z());
      ++n;
    });
  }
  // Mean square of n independent standard normal numbers: 1 ± √(2/n); for 2200, 5 deviations are 15
  // %. Headings 20 s apart are nearly independent (n = 100: 5 deviations are 0.7); the bias is
  // constant, so each seed counts once (n = 20: 4 deviations are 1.3).
  ASSERT_GT(n_nis, 2100);
  EXPECT_LE(refused, 2);  // four deviations are exceeded by 6 in 100 000: 0.15 of these
  EXPECT_NEAR(nis / n_nis, 1.0, 5 * std::sqrt(2.0 / n_nis));
  ASSERT_EQ(n, 100);
  EXPECT_NEAR(heading / n, 1.0, 0.7);
  EXPECT_GT(bias / n, 0.25);
  EXPECT_LT(bias / n, 2.3);
}

TEST(ExternalHeading, EstimatesTheGyroBias) {
  Scenario t = scenario(4);
  t.motion.bias_radps = {0.0, 0.0, 0.6 * kDegree};
  // No tilting and little acceleration, either of which makes the bias observable from gravity.
  t.motion.turn_radps = 0.0;
  t.motion.velocity_sigma = 0.05;
  t.motion.duration_s = 20.0;
  const auto none = [](auto&&...) {};
  const auto with = run(t, none);
  EXPECT_NEAR(with.gyro_bias_radps().z(), t.motion.bias_radps.z(), 0.25 * kDegree);
  // 20 headings of 1° and noise of 0.2°/√20: √(12/20³ + 0.2²/20) = 0.06°/s.
  EXPECT_LT(with.gyro_bias_sigma_radps().z(), 0.1 * kDegree);
  t.parameters.heading_history_s = 0.0;  // external headings unused
  const auto without = run(t, none);
  EXPECT_GT(without.gyro_bias_sigma_radps().z(), 0.25 * kDegree);
}

// At 1 rad/s a delay of half a second is half a radian: harmless if stamped with the time of
// validity, not with that of arrival.
TEST(ExternalHeading, DelayIsHarmlessWithTheTimeOfValidity) {
  const auto rms = [](Scenario t) {
    double squares = 0.0;
    int n = 0;
    run(t, [&](const auto& ahrs, const MargSample&, const SO3d& truth, auto) {
      if (ahrs.report().external.used < 10) return;
      const double off = wrap_to_pi(heading_of(ahrs.q_world_body()) - heading_of(truth));
      squares += off * off;
      ++n;
    });
    return n > 0 ? std::sqrt(squares / n) : INFINITY;
  };
  Scenario t = scenario(6);
  t.motion.turn_radps = 1.0;
  t.delay_s = 0.0;
  const double prompt = rms(t);
  t.delay_s = 0.5;
  const double late = rms(t);
  t.stamped_late = true;
  t.parameters.heading_gate_sigmas = 1e3;
  EXPECT_LT(late, 1.3 * prompt);
  EXPECT_GT(rms(t), 5.0 * prompt);
}

TEST(ExternalHeading, IsDeterministic) {
  const auto none = [](auto&&...) {};
  const auto a = run(scenario(7), none), b = run(scenario(7), none);
  EXPECT_EQ(a.q_world_body().quaternion().coeffs(), b.q_world_body().quaternion().coeffs());
  EXPECT_EQ(a.world_covariance(), b.world_covariance());
  EXPECT_EQ(a.gyro_bias_radps(), b.gyro_bias_radps());
}

}  // namespace
}  // namespace wayfare
