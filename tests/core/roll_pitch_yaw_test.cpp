#include <wayfare/core/se3.hpp>

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare {
namespace {

using std::numbers::pi;

double wrapped(double rad) { return std::remainder(rad, 2 * pi); }

// Rz(yaw) Ry(±90°) Rx(roll) = Rz(yaw ∓ roll) Ry(±90°): only that difference, or sum, is in the
// rotation.
TEST(RollPitchYaw, StraightUpOrDownRollIsZeroAndYawAllOfIt) {
  for (const double side : {1.0, -1.0})
    for (double roll = -3.0; roll <= 3.0; roll += 0.5)
      for (double yaw = -3.0; yaw <= 3.0; yaw += 0.3) {
        const Eigen::Vector3d in(roll, side * pi / 2, yaw);
        const Eigen::Vector3d out = roll_pitch_yaw_rad(rotation_from_roll_pitch_yaw(in));
        ASSERT_EQ(out[0], 0.0);
        ASSERT_NEAR(out[1], side * pi / 2, 1e-12);
        ASSERT_NEAR(wrapped(out[2] - (yaw - side * roll)), 0.0, 1e-14) << in.transpose();
      }
}

// However near to that, the angles give the rotation back. The rounding of a unit quaternion's
// product and of the matrix made of it is a few 1e-16; roll taken for zero adds 1e-12 at the most.
TEST(RollPitchYaw, GivesTheRotationBackAtEveryPitch) {
  Rng rng(3);
  for (int run = 0; run < 20000; ++run) {
    const double short_of = std::pow(10.0, rng.uniform(-18.0, 0.0));
    const double side = rng.uniform() < 0.5 ? -1.0 : 1.0;
    const Eigen::Vector3d in(rng.uniform(-pi, pi), side * (pi / 2 - short_of),
                             rng.uniform(-pi, pi));
    const SO3d q = rotation_from_roll_pitch_yaw(in);
    const Eigen::Vector3d out = roll_pitch_yaw_rad(q);
    const double tolerance = short_of < 2e-12 ? 2.5e-12 : 4e-15;
    ASSERT_LT(rotation_from_roll_pitch_yaw(out).minus(q).norm(), tolerance) << in.transpose();
    ASSERT_NEAR(wrapped((out[2] - side * out[0]) - (in[2] - side * in[0])), 0.0,
                short_of < 2e-12 ? 1e-14 : 2.0 * short_of * short_of + 1e-14)
        << in.transpose();
  }
}

TEST(RollPitchYaw, AnglesComeBackAwayFromThat) {
  Rng rng(4);
  for (int run = 0; run < 2000; ++run) {
    const Eigen::Vector3d in(rng.uniform(-pi, pi), rng.uniform(-1.4, 1.4), rng.uniform(-pi, pi));
    const Eigen::Vector3d out = roll_pitch_yaw_rad(rotation_from_roll_pitch_yaw(in));
    for (int i = 0; i < 3; ++i) ASSERT_NEAR(wrapped(out[i] - in[i]), 0.0, 1e-14);
  }
}

}  // namespace
}  // namespace wayfare
