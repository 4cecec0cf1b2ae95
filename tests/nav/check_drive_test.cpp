// Diagnosis of simulated drives: eight satellites with 2 m and 0.1 m/s, a unit at 50 Hz with the
// errors of an automotive MEMS unit, each with one fault.

#include <wayfare/nav/check_drive.hpp>

#include <algorithm>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/sim/gnss.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

namespace wayfare {
namespace {

using Cause = DriveFinding::Cause;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;

GnssInsRecording drive(std::uint64_t seed, const Vector3d& lever_arm_m = Vector3d::Zero()) {
  const sim::VehicleTrajectory trajectory = sim::demo_drive();
  sim::ImuParams unit;
  unit.period = std::chrono::milliseconds(20);
  sim::RangeParams receiver;
  receiver.max_satellites = 8;
  receiver.antenna_lever_arm_m = lever_arm_m;
  GnssInsRecording r;
  r.imu = sim::simulate_imu(trajectory, unit, Rng(seed).stream(0)).samples;
  r.ranges = sim::simulate_ranges(trajectory, sim::gps_and_galileo(), receiver, Rng(seed).stream(1))
                 .epochs;
  return r;
}

const GnssInsRecording& clean() {
  static const GnssInsRecording r = drive(101);
  return r;
}

std::vector<Cause> causes(const DriveCheck& check) {
  std::vector<Cause> result;
  for (const DriveFinding& f : check.findings) result.push_back(f.cause);
  return result;
}

double degrees_between(const SO3d& a, const SO3d& b) {
  return (a.inverse() * b).log().norm() / kDegree;
}

using Break = std::function<void(GnssInsRecording&, GnssInsOptions&)>;

Break readings(const Vector3d& rate, const Vector3d& force) {
  return [=](GnssInsRecording& r, GnssInsOptions&) {
    for (ImuSample& s : r.imu) {
      s.angular_rate_radps = s.angular_rate_radps.cwiseProduct(rate);
      s.specific_force_mps2 = s.specific_force_mps2.cwiseProduct(force);
    }
  };
}
Break mounted(double roll_deg, double pitch_deg, double yaw_deg) {
  return [=](GnssInsRecording&, GnssInsOptions& o) {
    o.q_body_imu = rotation_from_roll_pitch_yaw(kDegree * Vector3d(roll_deg, pitch_deg, yaw_deg));
  };
}
Break late(double seconds) {
  return [=](GnssInsRecording&, GnssInsOptions& o) { o.imu_time_offset_s += seconds; };
}

struct Fault {
  const char* name;
  Break damage;
  Cause cause;
  const char* text;
};

void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class CheckDriveFault : public testing::TestWithParam<Fault> {};

TEST_P(CheckDriveFault, IsNamed) {
  GnssInsRecording recording = clean();
  GnssInsOptions options;
  GetParam().damage(recording, options);
  const DriveCheck check = check_drive(recording, options);
  ASSERT_FALSE(check.findings.empty());
  EXPECT_EQ(check.findings.front().cause, GetParam().cause) << check.findings.front().text;
  EXPECT_THAT(check.findings.front().text, testing::HasSubstr(GetParam().text));
  EXPECT_FALSE(check.findings.front().option.empty());
  // What was found describes the drive: nothing is left to find.
  const DriveCheck again =
      check_drive(corrected(recording, check.estimate), corrected(options, check.estimate));
  EXPECT_THAT(causes(again), testing::IsEmpty()) << again.findings.front().text;
}

const Vector3d kOnes = Vector3d::Ones();
INSTANTIATE_TEST_SUITE_P(
    Simulated, CheckDriveFault,
    testing::Values(
        Fault{"yaw_180", mounted(0, 0, 180), Cause::mounting, "mounted 180"},
        Fault{"yaw_90", mounted(0, 0, 90), Cause::mounting, "mounted 90"},
        Fault{"roll_180", mounted(180, 0, 0), Cause::mounting, "upside down"},
        Fault{"pitch_90", mounted(0, 90, 0), Cause::mounting, "mounted 90"},
        Fault{"gyro_x", readings({-1, 1, 1}, kOnes), Cause::rate_sign, "gyro axis x"},
        Fault{"gyro_y", readings({1, -1, 1}, kOnes), Cause::rate_sign, "gyro axis y"},
        Fault{"gyro_z", readings({1, 1, -1}, kOnes), Cause::rate_sign, "gyro axis z"},
        Fault{"accel_x", readings(kOnes, {-1, 1, 1}), Cause::force_sign, "accelerometer axis x"},
        Fault{"accel_y", readings(kOnes, {1, -1, 1}), Cause::force_sign, "accelerometer axis y"},
        Fault{"accel_z", readings(kOnes, {1, 1, -1}), Cause::force_sign, "accelerometer axis z"},
        Fault{"accel_all", readings(kOnes, -kOnes), Cause::force_sign, "x and y and z"},
        Fault{"both_z", readings({1, 1, -1}, {1, 1, -1}), Cause::axis_sign, "axis z"},
        Fault{"degrees", readings(kOnes / kDegree, kOnes), Cause::rate_unit, "degrees per second"},
        Fault{"radians", readings(kOnes* kDegree, kOnes), Cause::rate_unit, "rad/s read as deg"},
        Fault{"g", readings(kOnes, kOnes / 9.80665), Cause::force_unit, "g read as m/s"},
        Fault{"early_1s", late(-1.0), Cause::time_offset, "early"},
        Fault{"late_1s", late(1.0), Cause::time_offset, "late"},
        Fault{"utc", late(-18.0), Cause::time_offset, "UTC for GPS"}),
    [](const auto& i) { return i.param.name; });

TEST(CheckDrive, FindsNothingOnCleanDrives) {
  for (const std::uint64_t seed : {102U, 103U, 104U}) {
    const DriveCheck check = check_drive(drive(seed), {});
    EXPECT_THAT(causes(check), testing::IsEmpty()) << check.findings.front().text;
    ASSERT_TRUE(check.estimate.q_body_imu && check.estimate.imu_time_offset_s);
    EXPECT_LT(degrees_between(*check.estimate.q_body_imu, SO3d()), 2.0);
    EXPECT_NEAR(*check.estimate.imu_time_offset_s, 0.0, 0.04);
  }
}

TEST(CheckDrive, FindsAllProperMountings) {
  for (int forward = 0; forward < 6; ++forward)
    for (int right = 0; right < 6; ++right) {
      if (forward / 2 == right / 2) continue;
      Eigen::Matrix3d body_imu = Eigen::Matrix3d::Zero();
      body_imu(0, forward / 2) = forward % 2 == 0 ? 1.0 : -1.0;
      body_imu(1, right / 2) = right % 2 == 0 ? 1.0 : -1.0;
      body_imu.row(2) = body_imu.row(0).cross(body_imu.row(1));
      GnssInsRecording r = clean();
      for (ImuSample& s : r.imu) {
        s.angular_rate_radps = body_imu.transpose() * s.angular_rate_radps;
        s.specific_force_mps2 = body_imu.transpose() * s.specific_force_mps2;
      }
      const DriveCheck check = check_drive(r, {});
      ASSERT_TRUE(check.estimate.q_body_imu);
      EXPECT_LT(degrees_between(*check.estimate.q_body_imu, SO3d(body_imu)), 2.0);
      EXPECT_EQ(check.estimate.accel_factor, kOnes);
      EXPECT_EQ(check.estimate.gyro_factor, kOnes);
      const bool as_configured = body_imu.isIdentity();
      EXPECT_EQ(check.findings.empty(), as_configured);
    }
}

TEST(CheckDrive, FindsAnOffsetBeyondTheRecording) {
  GnssInsOptions options;
  options.imu_time_offset_s = 1000.0;
  const DriveCheck check = check_drive(clean(), options);
  ASSERT_EQ(causes(check), (std::vector{Cause::no_overlap, Cause::time_offset}));
  EXPECT_NEAR(*check.estimate.imu_time_offset_s, 0.0, 0.04);
}

TEST(CheckDrive, RefinesMountingTimeAndLeverArm) {
  const Vector3d lever(0.6, -0.3, 0.0);
  GnssInsRecording r = drive(105, lever);
  std::erase_if(r.imu, [](const ImuSample& s) { return s.time > LogTime::from_seconds(200.0); });
  for (ImuSample& s : r.imu) s.time = s.time - std::chrono::milliseconds(130);
  DriveCheck check = check_drive(r, {});
  refine_estimate(r, {}, check.estimate);
  const DriveEstimate& e = check.estimate;
  EXPECT_LT(degrees_between(*e.q_body_imu, SO3d()), 2.0);
  EXPECT_NEAR(*e.imu_time_offset_s, 0.13, 0.02);
  EXPECT_NEAR(e.antenna_lever_arm_m->x(), lever.x(), 0.3);
  EXPECT_NEAR(e.antenna_lever_arm_m->y(), lever.y(), 0.3);
  // Without roll and pitch its height is not observable.
  EXPECT_GT(e.lever_arm_sigma_m.z(), 0.3);
  EXPECT_EQ(e.antenna_lever_arm_m->z(), 0.0);
}

TEST(CheckDrive, RunNamesRejectedMeasurements) {
  const auto good = run_gnss_ins(clean(), {});
  ASSERT_TRUE(good);
  EXPECT_TRUE(check_run(clean(), *good).empty());
  GnssInsOptions wrong;
  wrong.imu_time_offset_s = 1.5;
  const auto bad = run_gnss_ins(clean(), wrong);
  ASSERT_TRUE(bad);
  const auto findings = check_run(clean(), *bad);
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings.front().cause, Cause::rejected);
  EXPECT_THAT(findings.front().text, testing::HasSubstr("agree by themselves"));
}

TEST(CheckDriveBadInput, NothingIsFoundInNothing) {
  EXPECT_TRUE(check_drive({}, {}).findings.empty());
  GnssInsRecording r;
  r.imu.resize(1);
  EXPECT_TRUE(check_drive(r, {}).findings.empty());
  r = clean();
  r.ranges.clear();
  EXPECT_TRUE(check_drive(r, {}).findings.empty());
  DriveEstimate estimate;
  refine_estimate(r, {}, estimate);
  EXPECT_FALSE(estimate.antenna_lever_arm_m);
}

TEST(CheckDriveBadInput, ValuesThatAreNotFiniteAreLeftOut) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  GnssInsRecording r = clean();
  for (std::size_t i = 0; i < r.imu.size(); i += 97) r.imu[i].specific_force_mps2.y() = kNan;
  for (std::size_t i = 0; i < r.imu.size(); i += 89) r.imu[i].angular_rate_radps.x() = 1e300;
  for (std::size_t i = 0; i < r.ranges.size(); i += 7)
    for (CorrectedRange& s : r.ranges[i].satellites) s.range_m = s.range_rate_mps = kNan;
  const DriveCheck check = check_drive(r, {});
  EXPECT_THAT(causes(check), testing::IsEmpty()) << check.findings.front().text;
  ASSERT_TRUE(check.estimate.q_body_imu);
  EXPECT_LT(degrees_between(*check.estimate.q_body_imu, SO3d()), 2.0);
}

TEST(CheckDriveBadInput, MissingSensorsAreNamed) {
  GnssInsRecording silent = clean();
  for (ImuSample& s : silent.imu) s.angular_rate_radps.setZero();
  EXPECT_THAT(causes(check_drive(silent, {})), testing::Contains(Cause::silent_gyro));
  GnssInsRecording free = clean();
  for (ImuSample& s : free.imu) s.specific_force_mps2.z() += 9.8;
  EXPECT_THAT(causes(check_drive(free, {})), testing::Contains(Cause::no_gravity));
  GnssInsRecording few = clean();
  for (RangeEpoch& e : few.ranges) e.satellites.resize(3);
  EXPECT_THAT(causes(check_drive(few, {})), testing::Contains(Cause::no_position));
  GnssInsRecording code = clean();
  for (RangeEpoch& e : code.ranges)
    for (CorrectedRange& s : e.satellites)
      s.range_rate_mps = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(causes(check_drive(code, {})), testing::Contains(Cause::no_velocity));
}

TEST(CheckDrive, IsDeterministic) {
  const DriveCheck a = check_drive(clean(), {}), b = check_drive(clean(), {});
  EXPECT_EQ(*a.estimate.imu_time_offset_s, *b.estimate.imu_time_offset_s);
  EXPECT_EQ(a.estimate.q_body_imu->matrix(), b.estimate.q_body_imu->matrix());
}

}  // namespace
}  // namespace wayfare
