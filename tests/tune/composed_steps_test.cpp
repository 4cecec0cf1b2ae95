#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/inertial/ins_measurements.hpp>
#include <wayfare/inertial/ins_model.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

#include "tune/intervals.hpp"
#include "tune/kernels/composed_steps.hpp"

namespace wayfare {
namespace {

using namespace fitness_kernels;
using State = InsState<double>;
using Filter = Ekf<State>;

constexpr double kRate_hz = 100.0;

/// The unit on a minute of a drive with bends, climbs and stops; a tenth of the readings may be
/// missing.
struct Drive {
  sim::VehicleTrajectory trajectory = sim::demo_drive();
  LogTime begin = trajectory.begin() + std::chrono::seconds(20);
  std::vector<Step> steps;

  Drive(std::size_t steps_of_interval, bool missing) {
    sim::ImuParams unit;
    Rng rng(3);
    const auto samples = sim::simulate_imu(trajectory, unit, Rng(1)).samples;
    const ImuSample* last = nullptr;
    for (const ImuSample& s : samples) {
      if (s.time < begin || s.time > begin + std::chrono::seconds(60)) continue;
      if (missing && rng.uniform() < 0.1) continue;
      if (last) {
        Step step{};
        step.imu = between(*last, s);
        step.vibration.setConstant(1e-5 * rng.uniform());
        step.satellites = steps.size() % steps_of_interval == steps_of_interval - 1;
        steps.push_back(step);
      }
      last = &s;
    }
    divide_into_intervals(steps);
  }
};

/// Largest differences of the covariances, relative to standard deviations, and of the states.
struct Differences {
  double covariance = 0.0, sigma = 0.0, position_m = 0.0, velocity_mps = 0.0, attitude_rad = 0.0;
};

Differences against_every_step(const Drive& drive, const InsNoise<double>& noise) {
  const NavState start = drive.trajectory.state(drive.begin);
  const LocalTangentPlane plane(start.position);
  InsModel<double> model(plane, noise);
  model.prepare(1.0 / kRate_hz);
  ComposedSteps<double> composed(plane, noise, 1.0 / kRate_hz);

  State x;
  x.velocity_mps = start.velocity_ned_mps;
  x.q_nu = start.q_nb;
  Filter::Square p = Filter::Square::Zero();
  for (int i = 0; i < 3; ++i) {
    p(i, i) = 1.0;
    p(3 + i, 3 + i) = 0.01;
    p(6 + i, 6 + i) = 1e-4;
    p(21, 21) = 100.0;
    p(22, 22) = 1.0;
  }
  for (int i = 0; i < 12; ++i) p(9 + i, 9 + i) = noise.sigma[i] * noise.sigma[i];
  Filter filter(x, p);

  Differences worst;
  Filter by_interval = filter;
  bool begins = true;
  for (const Step& s : drive.steps) {
    if (begins) {
      by_interval = filter;
      composed.begin(by_interval.state());
    }
    filter.predict(model, s.imu);
    const Eigen::Vector3d vibration = 1e-4 * s.vibration;
    for (int i = 0; i < 3; ++i) filter.add_variance(ins_state::kAttitude + i, vibration[i]);
    composed.add(s, vibration);
    begins = s.ends_interval;
    if (!s.ends_interval) continue;
    by_interval.predict([&](const State& from) { return composed.step(from); });
    const Filter::Square& a = filter.covariance();
    const Filter::Square& b = by_interval.covariance();
    for (int i = 0; i < State::kDof; ++i) {
      worst.sigma = std::max(worst.sigma, std::abs(b(i, i) / a(i, i) - 1.0));
      for (int j = 0; j < State::kDof; ++j)
        worst.covariance =
            std::max(worst.covariance, std::abs(b(i, j) - a(i, j)) / std::sqrt(a(i, i) * a(j, j)));
    }
    const auto tau = by_interval.state().minus(filter.state());
    worst.position_m = std::max(worst.position_m, tau.segment<3>(0).norm());
    worst.velocity_mps = std::max(worst.velocity_mps, tau.segment<3>(3).norm());
    worst.attitude_rad = std::max(worst.attitude_rad, tau.segment<3>(6).norm());
    for (int axis = 0; axis < 3; ++axis) {  // as exact as GNSS makes them
      filter.update(VelocityModel<double>{axis, filter.state().velocity_mps[axis], 0.0025});
      filter.update(AntennaPositionModel<double>{plane, filter.state().position_m,
                                                 Eigen::Vector3d::Unit(axis),
                                                 Eigen::Vector3d::Zero(), 1.0});
    }
  }
  return worst;
}

// A variance that differs by a millionth changes gains, and what they correct, by as much.
TEST(ComposedSteps, AgreeWithEveryStep) {
  for (const std::size_t interval : {1U, 2U, 3U, 7U, 10U, 20U, 100U})
    for (const bool missing : {false, true}) {
      const Differences d =
          against_every_step(Drive(interval, missing), {ImuNoise{}, ReceiverClockNoise{}});
      EXPECT_LT(d.covariance, 2e-6) << interval << ' ' << missing;
      EXPECT_LT(d.sigma, 1e-6) << interval << ' ' << missing;
      // Gravity at the middle of a panel: 3 m of climb within one are 1e-5 m/s² too much at its
      // beginning and too little at its end.
      EXPECT_LT(d.position_m, 1e-6) << interval << ' ' << missing;
      EXPECT_LT(d.velocity_mps, 2e-7) << interval << ' ' << missing;
      EXPECT_LT(d.attitude_rad, 1e-11) << interval << ' ' << missing;
    }
}

// Where the noise within an interval is most of the covariance, parabolas between ten nodes show.
TEST(ComposedSteps, AgreeForLargeNoise) {
  using Change = void (*)(InsNoise<double>&);
  const Change larger[] = {[](InsNoise<double>& n) { n.sigma *= 30.0; },
                           [](InsNoise<double>& n) { n.sigma *= 30.0, n.tau_s /= 30.0; },
                           [](InsNoise<double>& n) { n.gyro_white *= 30.0; },
                           [](InsNoise<double>& n) { n.accel_white *= 30.0; },
                           [](InsNoise<double>& n) { n.gyro_white[0] *= 30.0; }};
  for (const bool missing : {false, true})
    for (const Change& change : larger) {
      InsNoise<double> noise{ImuNoise{}, ReceiverClockNoise{}};
      change(noise);
      const Differences d = against_every_step(Drive(100, missing), noise);
      EXPECT_LT(d.covariance, 3e-5) << &change - larger << ' ' << missing;
    }
}

// A parabola through three nodes is exact for 1, t and t².
TEST(ComposedSteps, SharesOfNoiseAreThoseOfAParabola) {
  const Drive drive(100, true);
  std::vector<double> nodes{0.0}, ends_s;
  std::size_t first = 0;
  for (std::size_t i = 0; i < drive.steps.size(); ++i) {
    ends_s.push_back((ends_s.empty() ? 0.0 : ends_s.back()) + drive.steps[i].imu.dt_s);
    if (drive.steps[i].ends_panel) nodes.push_back(ends_s.back());
    if (!drive.steps[i].ends_interval) continue;
    ASSERT_LE(nodes.size(), kMostPanels + 1);
    for (std::size_t j = first; nodes.size() > 2 && j <= i; ++j)
      for (int power = 0; power < 3; ++power) {
        double sum = 0.0;
        for (std::size_t k = 0; k < 3; ++k)
          sum +=
              drive.steps[j].shares[k] * std::pow(nodes.at(drive.steps[j].first_node + k), power);
        EXPECT_NEAR(sum, std::pow(ends_s[j - first], power), 1e-12);
      }
    first = i + 1;
    nodes = {0.0};
    ends_s.clear();
  }
  EXPECT_EQ(first, drive.steps.size());
}

}  // namespace
}  // namespace wayfare
