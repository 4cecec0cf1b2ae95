// Recordings with optical ground truth: BROAD (Laidig et al. 2021).

#include <array>
#include <string>

#include <gtest/gtest.h>

#include <wayfare/inertial/ahrs.hpp>
#include "broad.hpp"
#include "io/support.hpp"

namespace wayfare {
namespace {

// The default parameters were chosen on the first half; the magnetometer delay was found on all
// ten.
constexpr std::array<const char*, 5> kChosenOn = {
    "02_undisturbed_slow_rotation_B", "09_undisturbed_fast_rotation_with_breaks_B",
    "16_undisturbed_fast_translation_B", "21_undisturbed_fast_combined",
    "28_disturbed_stationary_magnet_A"};
constexpr std::array<const char*, 5> kTestedOn = {
    "05_undisturbed_slow_rotation_with_breaks_B", "11_undisturbed_slow_translation_B",
    "18_undisturbed_fast_translation_with_breaks_B", "24_disturbed_tapping_A",
    "33_disturbed_attached_magnet_2cm"};

std::string trial_path(const char* name) {
  return testing::recording("ahrs/broad10_half/" + std::string(name) + ".f32.gz");
}

/// Mean over the trials, degrees: total, heading, inclination.
template <class Estimator>
Eigen::Vector3d mean_error(const std::array<const char*, 5>& trials, double worst_deg) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const char* name : trials) {
    const auto trial = testing::read_broad(trial_path(name));
    EXPECT_TRUE(trial) << name;
    if (!trial) continue;
    Estimator estimator;
    const auto e = testing::broad_error(estimator, *trial);
    EXPECT_LT(e.total.degrees(), worst_deg) << name;
    sum += Eigen::Vector3d(e.total.degrees(), e.heading.degrees(), e.inclination.degrees());
  }
  return sum / static_cast<double>(trials.size());
}

#define WAYFARE_NEEDS_BROAD() \
  WAYFARE_NEEDS_RECORDING(broad, "ahrs/broad10_half/33_disturbed_attached_magnet_2cm.f32.gz")

// The best filter published with one set of parameters (VQF, Laidig and Seel 2023) has 2.43° total,
// 2.27° heading and 0.72° inclination over all thirty comparable trials.
TEST(AhrsBroad, BelowTheBestPublishedErrors) {
  WAYFARE_NEEDS_BROAD();
  const auto chosen = mean_error<Ahrs<frame::Enu>>(kChosenOn, 2.4);
  const auto tested = mean_error<Ahrs<frame::Enu>>(kTestedOn, 2.4);
  const Eigen::Vector3d all = 0.5 * (chosen + tested);
  EXPECT_LT(all[0], 2.1);
  EXPECT_LT(all[1], 1.9);
  EXPECT_LT(all[2], 0.72);
  // Measured 1.16 / 1.01 / 0.52: the test trials are not worse.
  EXPECT_LT(tested[0], 1.4);
  EXPECT_LT(tested[1], 1.25);
  EXPECT_LT(tested[2], 0.6);
}

TEST(AhrsBroad, FloatIsAsGood) {
  WAYFARE_NEEDS_BROAD();
  const auto tested = mean_error<Ahrs<frame::Ned, float>>(kTestedOn, 2.4);
  EXPECT_LT(tested[0], 1.4);
}

// Published for their best common gains: Madgwick 4.88°, Mahony 8.18°. Agreement confirms the
// implementations and the error measure.
TEST(AhrsBroad, BaselinesHaveTheirPublishedErrors) {
  WAYFARE_NEEDS_BROAD();
  const auto madgwick = 0.5 * (mean_error<MadgwickAhrs<frame::Enu>>(kChosenOn, 15.0)[0] +
                               mean_error<MadgwickAhrs<frame::Enu>>(kTestedOn, 15.0)[0]);
  EXPECT_NEAR(madgwick, 4.88, 1.0);
  const auto mahony = 0.5 * (mean_error<MahonyAhrs<frame::Ned>>(kChosenOn, 40.0)[0] +
                             mean_error<MahonyAhrs<frame::Ned>>(kTestedOn, 40.0)[0]);
  EXPECT_NEAR(mahony, 8.18, 3.0);
}

}  // namespace
}  // namespace wayfare
