// Wheel speeds as measurements of the GNSS/INS filter.

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <wayfare/eval/consistency.hpp>
#include <wayfare/inertial/ins_measurements.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/nav/odometer.hpp>
#include <wayfare/nav/outage.hpp>
#include <wayfare/sim/ins_monte_carlo.hpp>
#include <wayfare/testing/filter_laws.hpp>

#include "filter/numeric_jacobian.hpp"

namespace wayfare {
namespace {

using Eigen::Vector3d;
using WithWheels = InsState<double, 2, ins::Odometer<double>>;

TEST(AxleVelocity, RowIsTheDerivative) {
  WithWheels x;
  x.velocity_mps = Vector3d(12.0, -7.0, 0.4);
  x.q_nu = SO3d::exp(Vector3d(0.05, -0.1, 2.2));
  x.gyro_bias_radps = Vector3d(0.002, -0.001, 0.003);
  x.odometer << 0.02, 0.01, -0.03, -1.2, 0.3, 0.8;
  const Eigen::Matrix3d body_unit = SO3d::exp(Vector3d(0.3, -0.2, 1.1)).matrix();
  for (int axis = 0; axis < 3; ++axis) {
    const AxleVelocityModel<double, 2> model{axis, 5.0, 0.01, body_unit, Vector3d(0.1, -0.2, 0.5)};
    const auto numeric =
        tests::numeric_gradient([&](const WithWheels& s) { return -model(s).innovation; }, x,
                                TangentOf<WithWheels>::Constant(1e-4));
    const auto h = testing::FilterLaws<WithWheels>::dense(model(x).row);
    for (int i = 0; i < h.size(); ++i) {
      // The model neglects the gyro scale in the lever arm's velocity.
      if (i >= ins_state::kGyroScale && i < ins_state::kAccelScale) continue;
      EXPECT_NEAR(h[i], numeric[i], 1e-7) << "axis " << axis << ", entry " << i;
    }
  }
}

// At rest about a vertical axis, ω × l is the velocity of the axle.
TEST(AxleVelocity, TurningOnTheSpotMovesTheAxleAcross) {
  WithWheels x;
  x.odometer.tail<3>() = Vector3d(-2.0, 0.0, 0.0);
  const Vector3d gyro(0.0, 0.0, 0.5);
  const auto innovation = [&](int axis) {
    return AxleVelocityModel<double, 2>{axis, 0.0, 0.01, Eigen::Matrix3d::Identity(), gyro}(x)
        .innovation;
  };
  EXPECT_NEAR(innovation(0), 0.0, 1e-12);
  EXPECT_NEAR(innovation(1), 1.0, 1e-12);  // −(0.5 · −2)
  EXPECT_NEAR(innovation(2), 0.0, 1e-12);
}

sim::InsMonteCarloOptions with_wheels() {
  sim::InsMonteCarloOptions o;
  o.ranges.max_satellites = 8;
  o.filter.zero_velocity_updates = false;
  o.filter.non_holonomic_in_outage = false;  // errors of constraints are not white noise
  o.filter.odometer.emplace();
  o.filter.odometer->speed_sigma_mps = 0.05;
  o.wheels.sigma_mps = 0.05;
  o.wheels.resolution_mps = 0.0;
  o.wheels.scale = 0.02;
  o.wheels.lever_arm_m = {0.0, 0.3, 0.5};
  o.threads = 2;
  return o;
}

TEST(Odometer, ErrorsOfDrivesMatchTheCovariance) {
  const auto courses =
      sim::ins_monte_carlo(sim::demo_drive(), sim::gps_and_galileo(), 8, with_wheels(), Rng(3));
  eval::IndependentMean all, navigation;
  for (const sim::InsErrorSeries& course : courses) {
    double nees = 0.0, of_navigation = 0.0;
    for (const sim::InsErrorAt& at : course) nees += at.nees, of_navigation += at.navigation_nees;
    all.add(nees / static_cast<double>(course.size()));
    navigation.add(of_navigation / static_cast<double>(course.size()));
  }
  // Expected 23 and 9; the mean over a drive has few independent values: a standard deviation of
  // about a fifth, of the mean of eight a fourteenth. Three of those.
  EXPECT_NEAR(all.mean(), 23.0, 0.22 * 23.0);
  EXPECT_NEAR(navigation.mean(), 9.0, 0.22 * 9.0);
}

/// A drive with wheels that slip.
struct Drive {
  GnssInsRecording recording;
  GnssInsOptions options;
  std::vector<bool> slips;
  sim::WheelSpeedParams wheels;

  explicit Drive(double slips_per_hour) {
    const auto path = sim::demo_drive();
    sim::ImuParams unit;
    recording.imu = sim::simulate_imu(path, unit, Rng(5)).samples;
    recording.ranges =
        sim::simulate_ranges(path, sim::gps_and_galileo(), sim::RangeParams{}, Rng(6)).epochs;
    // The simulated vehicle does not slide at the unit: the axle is beside or below it.
    wheels.lever_arm_m = {0.0, 0.3, 0.5};
    wheels.slips_per_hour = slips_per_hour;
    auto simulated = sim::simulate_wheel_speeds(path, wheels, Rng(7));
    recording.wheels = std::move(simulated.readings);
    slips = std::move(simulated.slips);
    options.odometer.emplace();
  }
};

TEST(Odometer, LearnsScaleAndLeverArm) {
  const Drive drive(0.0);
  std::optional<GnssInsEstimate> last;
  const auto result = smooth_gnss_ins(drive.recording, drive.options, {}, {},
                                      [&](const GnssInsEstimate& e) { last = last ? last : e; });
  ASSERT_TRUE(result);
  ASSERT_TRUE(last && last->odometer);
  const OdometerEstimate& o = *last->odometer;
  EXPECT_LT(o.sigma[0], 0.002);
  EXPECT_NEAR(o.scale, drive.wheels.scale, 4.0 * o.sigma[0]);
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(o.direction_rad[i], 0.0, 4.0 * o.sigma[1 + i]);
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(o.lever_arm_m[i], drive.wheels.lever_arm_m[i], 4.0 * o.sigma[3 + i]);
  EXPECT_LT(o.sigma[3], 0.3);  // forward, from the velocity across in turns
}

TEST(Odometer, RejectsWheelsThatSlip) {
  const Drive drive(60.0);
  const auto result = run_gnss_ins(drive.recording, drive.options);
  ASSERT_TRUE(result);
  std::size_t slipping = 0, rejected = 0, wrongly = 0, good = 0;
  const auto& wheels = drive.recording.wheels;
  std::size_t k = 0;
  for (const InnovationRecord& i : result->innovations) {
    if (i.kind != InnovationRecord::Kind::wheels) continue;
    while (wheels[k].time < i.time) ++k;
    // Beyond the gate: five standard deviations of the innovation.
    const double excess = std::abs(i.innovation) / i.sigma;
    if (drive.slips[k] && excess > 5.0) ++slipping, rejected += i.accepted ? 0 : 1;
    if (!drive.slips[k]) ++good, wrongly += i.accepted ? 0 : 1;
  }
  EXPECT_GT(slipping, 10U);
  EXPECT_EQ(rejected, slipping);
  EXPECT_LT(wrongly, good / 50);
}

// Of the position relative to that at the beginning of the outage.
TEST(Odometer, DriftsLessInOutages) {
  const Drive drive(0.0);
  const auto path = sim::demo_drive();
  const auto drift = [&](GnssInsRecording recording, const GnssInsOptions& options) {
    double sum = 0.0;
    for (const double begin_s : {70.0, 130.0, 190.0, 250.0}) {
      const LogTime begin = recording.imu.front().time + from_seconds(begin_s);
      const OutageWindow window{begin, begin + from_seconds(30.0), 0};
      GnssInsRecording cut = recording;
      std::erase_if(cut.ranges, [&](const RangeEpoch& e) { return window.contains(e.time); });
      const auto result = run_gnss_ins(cut, options);
      std::vector<Vector3d> errors;
      for (const GnssInsPoint& p : result->points)
        if (window.contains(p.nav.time))
          errors.push_back(ned_from_geodetic(p.nav.position, path.state(p.nav.time).position));
      sum += (errors.back() - errors.front()).head<2>().norm();
    }
    return sum;
  };
  GnssInsOptions without = drive.options;
  without.odometer.reset();
  EXPECT_LT(2.0 * drift(drive.recording, drive.options), drift(drive.recording, without));
}

TEST(Odometer, RefusesBadReadingsAndStaysUntouched) {
  Drive drive(0.0);
  GnssIns filter(drive.options);
  for (std::size_t i = 0; i < 2000; ++i) ASSERT_TRUE(filter.add(drive.recording.imu[i]));
  const auto refused = [](const Result<void>& r, const char* what) {
    ASSERT_FALSE(r);
    EXPECT_NE(r.error().message.find(what), std::string::npos) << r.error().message;
  };
  const LogTime now = drive.recording.imu[1990].time;
  refused(filter.add(WheelSpeed{now, std::numeric_limits<double>::quiet_NaN()}), "implausible");
  refused(filter.add(WheelSpeed{now, 1e300}), "implausible");
  refused(GnssIns(GnssInsOptions{}).add(WheelSpeed{now, 1.0}), "odometer");
  refused(GnssIns(GnssInsOptions{}).add(WheelSpeed{now, 1.0}),
          std::to_string(now.seconds()).substr(0, 4).c_str());
}

TEST(Odometer, WheelsThatAreNotAskedForAreNoError) {
  Drive drive(0.0);
  drive.options.odometer.reset();
  const auto with = run_gnss_ins(drive.recording, drive.options);
  drive.recording.wheels.clear();
  const auto without = run_gnss_ins(drive.recording, drive.options);
  ASSERT_TRUE(with && without);
  EXPECT_EQ(with->points.back().nav.velocity_ned_mps, without->points.back().nav.velocity_ned_mps);
}

}  // namespace
}  // namespace wayfare
