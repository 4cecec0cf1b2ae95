// Laws of every attitude estimator.

#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/inertial/ahrs.hpp>
#include "motion.hpp"

namespace wayfare {
namespace {

using testing::kDegree;
using testing::Motion;
using testing::MotionOptions;

template <class E>
class AttitudeLaws : public ::testing::Test {};
using Estimators = ::testing::Types<Ahrs<frame::Enu, double>, Ahrs<frame::Ned, double>,
                                    Ahrs<frame::Enu, float>, Ahrs<frame::Ned, float>,
                                    MadgwickAhrs<frame::Enu>, MadgwickAhrs<frame::Ned, float>,
                                    MahonyAhrs<frame::Ned>, MahonyAhrs<frame::Enu, float>>;
TYPED_TEST_SUITE(AttitudeLaws, Estimators);

/// Limits: the filter with a motion model is more accurate; Madgwick's correction of constant speed
/// oscillates by 2β·dt = 2.4 mrad here.
template <class E>
struct Expected {
  static constexpr double kRmse_deg = 3.0, kSameness = 5e-3;
};
template <class W>
struct Expected<Ahrs<W, double>> {
  static constexpr double kRmse_deg = 1.0, kSameness = 1e-7;
};
template <class W>
struct Expected<Ahrs<W, float>> {
  static constexpr double kRmse_deg = 1.0, kSameness = 2e-3;
};

/// In ENU and double for any estimator.
template <class E>
SO3d enu(const E& e) {
  return rotation_from_enu<typename E::World, double>().inverse() *
         e.q_world_body().template cast<double>();
}

template <class E>
std::vector<SO3d> run(E& e, const MargRecording& samples) {
  std::vector<SO3d> result;
  for (const MargSample& s : samples) {
    e.add(s);
    result.push_back(enu(e));
  }
  return result;
}

MotionOptions noisy_motion() {
  MotionOptions o;
  o.rest_s = 3.0;
  o.velocity_sigma = 0.3;
  o.bias_radps = {0.004, -0.003, 0.002};
  o.rate_density = 0.1 * kDegree;
  o.force_density = 0.01;
  o.field_noise_uT = 0.5;
  return o;
}

TYPED_TEST(AttitudeLaws, FollowsAKnownMotion) {
  static_assert(AttitudeEstimator<TypeParam>);
  const Motion motion = testing::simulate(noisy_motion());
  TypeParam e;
  EXPECT_FALSE(e.ready());
  const auto q = run(e, motion.samples);
  EXPECT_TRUE(e.ready());
  eval::AttitudeRmse rmse;
  for (std::size_t i = 1000; i < q.size(); ++i)
    rmse.add(eval::attitude_error(q[i], motion.q_enu_body[i]));
  EXPECT_LT(rmse.value().total.degrees(), Expected<TypeParam>::kRmse_deg);
}

TYPED_TEST(AttitudeLaws, IsEquivariantUnderSensorMounting) {
  MotionOptions o = noisy_motion();
  o.rate_density = o.force_density = o.field_noise_uT = 0.0;  // noise is not rotated along
  const Motion straight = testing::simulate(o);
  o.q_body_sensor = SO3d::exp({0.4, 2.0, -1.3});
  const Motion turned = testing::simulate(o);
  TypeParam a, b;
  const auto qa = run(a, straight.samples), qb = run(b, turned.samples);
  for (std::size_t i = 0; i < qa.size(); i += 50)
    ASSERT_LT(qb[i].minus(qa[i] * o.q_body_sensor).norm(), Expected<TypeParam>::kSameness) << i;
}

TYPED_TEST(AttitudeLaws, NonFiniteReadingsLeaveTheEstimateUnchanged) {
  const Motion motion = testing::simulate(noisy_motion());
  TypeParam clean, dirty;
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    const MargSample& s = motion.samples[i];
    clean.add(s);
    dirty.add(s);
    if (i % 7 != 3) continue;
    MargSample bad;
    bad.time = s.time + std::chrono::milliseconds(1);
    if (i % 2 == 0) bad.angular_rate_radps.x() = 1.0;  // the others stay NaN
    if (i % 3 == 0) bad.specific_force_mps2.y() = std::numeric_limits<double>::infinity();
    const MargUpdateStatus status = dirty.add(bad);
    ASSERT_EQ(status.gyro, UpdateStatus::missing);
    ASSERT_EQ(status.accelerometer, UpdateStatus::missing);
    ASSERT_EQ(status.magnetometer, UpdateStatus::missing);
    ASSERT_EQ(clean.q_world_body().quaternion().coeffs(),
              dirty.q_world_body().quaternion().coeffs());
  }
}

TYPED_TEST(AttitudeLaws, LateReadingsAreRejected) {
  const Motion motion = testing::simulate(noisy_motion());
  TypeParam e;
  run(e, MargRecording(motion.samples.begin(), motion.samples.begin() + 100));
  const auto before = e.q_world_body().quaternion().coeffs().eval();
  const MargUpdateStatus status = e.add(motion.samples[98]);
  EXPECT_EQ(status.gyro, UpdateStatus::late);
  EXPECT_EQ(status.accelerometer, UpdateStatus::late);
  EXPECT_EQ(status.magnetometer, UpdateStatus::late);
  EXPECT_EQ(before, e.q_world_body().quaternion().coeffs());
}

}  // namespace
}  // namespace wayfare
