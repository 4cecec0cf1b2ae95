// Carrier phases as measurements of the GNSS/INS filter.

#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/eval/consistency.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/nav/phase_change.hpp>
#include <wayfare/sim/ins_monte_carlo.hpp>
#include <wayfare/testing/filter_laws.hpp>

#include "filter/numeric_jacobian.hpp"

namespace wayfare {
namespace {

using Eigen::Vector3d;
using WithEarlier = InsState<double, 2, ins::EarlierAntenna<double>>;

const Geodetic kAnchor{Angle::degrees(48.7), Angle::degrees(9.1), 300.0};
const Vector3d kLever(0.8, -0.4, -1.3);

WithEarlier some_state() {
  WithEarlier x;
  x.position_m = Vector3d(1200.0, -2800.0, 15.0);
  x.velocity_mps = Vector3d(12.0, -7.0, 0.4);
  x.q_nu = SO3d::exp(Vector3d(0.05, -0.1, 2.2));
  x.clock << 140.0, 3.0, -12.0, 5.0;
  x.earlier.head<3>() =
      ecef_from_geodetic(kAnchor) + rotation_ecef_ned(kAnchor) * Vector3d(1190.0, -2790.0, 14.0);
  x.earlier[3] = 137.0;
  return x;
}

Vector3d satellite(double later_s) {
  return ecef_from_geodetic(kAnchor) +
         rotation_ecef_ned(kAnchor) * Vector3d(1.1e7, -0.9e7, -1.6e7) +
         later_s * Vector3d(-900.0, 2500.0, 1700.0);
}

TEST(PhaseChange, RowIsTheDerivative) {
  const LocalTangentPlane plane(kAnchor);
  CorrectedRange now;
  now.position_ecef_m = satellite(1.0);
  const SatelliteView view(now, plane);
  const PhaseChangeModel<double, 2> model{
      {plane, view, 1000.0, 1.0, kLever, -1}, satellite(0.0), 2.3e7, 1e-4};
  TangentOf<WithEarlier> step = TangentOf<WithEarlier>::Constant(1e-4);
  step.head<3>().setConstant(10.0), step.tail<4>().setConstant(10.0);
  const WithEarlier x = some_state();
  const auto numeric =
      tests::numeric_gradient([&](const WithEarlier& s) { return -model(s).innovation; }, x, step);
  const auto h = testing::FilterLaws<WithEarlier>::dense(model(x).row);
  // Rounding of 2e7 m is 4e-9 m; over 2e-4 rad that is 2e-5.
  for (int i = 0; i < h.size(); ++i) EXPECT_NEAR(h[i], numeric[i], 1e-4) << "entry " << i;
}

/// The antenna of the state itself, in Earth-fixed axes, and its clock.
Eigen::Vector4d antenna(const LocalTangentPlane& plane, const WithEarlier& x) {
  return CloneAntenna<double, 2>{plane, 0.0, kLever}(x).state.earlier;
}

TEST(CloneAntenna, CopiesTheAntennaWithItsError) {
  const LocalTangentPlane plane(kAnchor);
  const WithEarlier x = some_state();
  const auto clone = CloneAntenna<double, 2>{plane, 0.0, kLever}(x);
  // An independent formula: the unit's geodetic position and the lever arm in its local level.
  const Geodetic at = plane.geodetic(x.position_m);
  const Vector3d expected = ecef_from_geodetic(at) + rotation_ecef_ned(at) * (x.q_nu * kLever);
  EXPECT_LT((clone.state.earlier.head<3>() - expected).norm(), 2e-3);  // of the plane over 3 km
  EXPECT_EQ(clone.state.earlier[3], x.clock[0]);
  TangentOf<WithEarlier> step = TangentOf<WithEarlier>::Constant(1e-4);
  step.head<3>().setConstant(10.0);
  for (int row = 0; row < 4; ++row) {
    const auto numeric = tests::numeric_gradient(
        [&](const WithEarlier& s) { return antenna(plane, s)[row]; }, x, step);
    for (int i = 0; i < WithEarlier::kDof; ++i)
      EXPECT_NEAR(clone.phi(WithEarlier::kDof - 4 + row, i), numeric[i], 1e-4) << row << ", " << i;
  }
}

TEST(CloneAntenna, TheDifferenceToTheCopyIsCertain) {
  const LocalTangentPlane plane(kAnchor);
  Ekf<WithEarlier> filter(some_state(), 4.0 * SquareOf<WithEarlier>::Identity());
  const CloneAntenna<double, 2> clone{plane, 0.0, kLever};
  filter.predict(clone);
  const auto rows = clone(filter.state()).phi.bottomRows<4>();
  Eigen::Matrix<double, 4, WithEarlier::kDof> difference = rows;
  difference.rightCols<4>() -= Eigen::Matrix4d::Identity();
  const Eigen::Matrix4d s = difference * filter.covariance() * difference.transpose();
  EXPECT_LT(s.cwiseAbs().maxCoeff(), 1e-12);
}

sim::InsMonteCarloOptions with_phases() {
  sim::InsMonteCarloOptions o;
  o.ranges.max_satellites = 8;
  o.ranges.antenna_lever_arm_m = {0.3, -0.2, -1.4};
  o.ranges.phases.emplace();
  o.filter.zero_velocity_updates = false;
  o.filter.non_holonomic_in_outage = false;  // errors of constraints are not white noise
  o.threads = 2;
  return o;
}

struct Figures {
  eval::IndependentMean nees, navigation;
  double velocity_mps = 0.0;  ///< RMS of three dimensions, after the first minute
};

Figures figures_of(const sim::InsMonteCarloOptions& options, std::uint64_t seed) {
  const auto courses =
      sim::ins_monte_carlo(sim::demo_drive(), sim::gps_and_galileo(), 6, options, Rng(seed));
  Figures f;
  double squares = 0.0, count = 0.0;
  for (const sim::InsErrorSeries& course : courses) {
    double nees = 0.0, navigation = 0.0;
    for (const sim::InsErrorAt& at : course) {
      nees += at.nees, navigation += at.navigation_nees;
      if (to_seconds(at.time - course.front().time) < 60.0) continue;
      squares += at.error.segment<3>(ins_state::kVelocity).squaredNorm(), count += 1.0;
    }
    f.nees.add(nees / static_cast<double>(course.size()));
    f.navigation.add(navigation / static_cast<double>(course.size()));
  }
  f.velocity_mps = std::sqrt(squares / count);
  return f;
}

TEST(PhaseChange, ErrorsMatchTheCovarianceAndVelocityIsThreeTimesAsGood) {
  auto options = with_phases();
  const Figures without = figures_of(options, 11);
  options.filter.carrier_phase.emplace();
  const Figures with = figures_of(options, 11);
  // As in Odometer.ErrorsOfDrivesMatchTheCovariance.
  EXPECT_NEAR(with.nees.mean(), 23.0, 0.25 * 23.0);
  EXPECT_NEAR(with.navigation.mean(), 9.0, 0.25 * 9.0);
  EXPECT_GT(without.velocity_mps, 3.0 * with.velocity_mps);
}

TEST(PhaseChange, CycleSlipsDoNoHarm) {
  auto options = with_phases();
  options.filter.carrier_phase.emplace();
  const Figures clean = figures_of(options, 12);
  options.ranges.phases->slips_per_satellite_hour = 60.0;
  const Figures slipping = figures_of(options, 12);
  EXPECT_LT(slipping.velocity_mps, 1.2 * clean.velocity_mps);
  EXPECT_NEAR(slipping.nees.mean(), 23.0, 0.25 * 23.0);
}

TEST(PhaseChange, WithoutPhasesAllIsAsBefore) {
  const auto path = sim::demo_drive();
  GnssInsRecording recording;
  recording.imu = sim::simulate_imu(path, sim::ImuParams{}, Rng(5)).samples;
  recording.ranges =
      sim::simulate_ranges(path, sim::gps_and_galileo(), sim::RangeParams{}, Rng(6)).epochs;
  recording.imu.resize(6000);
  GnssInsOptions options;
  const auto plain = run_gnss_ins(recording, options);
  options.carrier_phase.emplace();
  const auto with = run_gnss_ins(recording, options);
  ASSERT_TRUE(plain && with);
  // The further states change only the order of roundings.
  EXPECT_LT(
      (plain->points.back().nav.velocity_ned_mps - with->points.back().nav.velocity_ned_mps).norm(),
      1e-9);
}

}  // namespace
}  // namespace wayfare
