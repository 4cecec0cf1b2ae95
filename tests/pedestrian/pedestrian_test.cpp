// Steps, their lengths and directions, on simulated walks and faulty input.
#include <wayfare/pedestrian/detail/straight_walk.hpp>
#include <wayfare/pedestrian/detail/swings.hpp>
#include <wayfare/pedestrian/detail/walking_heading.hpp>
#include <wayfare/pedestrian/parameters.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/pedestrian/step.hpp>
#include <wayfare/pedestrian/step_detector.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/sync/odometry_track.hpp>
#include "phone_walk.hpp"

namespace wayfare {
namespace {

using testing::PhoneWalk;
using testing::PhoneWalkOptions;
using testing::walk_phone;

static_assert(StepLengthModel<ConstantStep> && StepLengthModel<WeinbergStep> &&
              StepLengthModel<KimStep> && StepLengthModel<HeightFrequencyStep>);

std::vector<Step> steps_of(const MargRecording& samples, const StepParameters& p = {}) {
  StepDetector detector(p);
  std::vector<Step> steps;
  for (const MargSample& s : samples)
    detector.add(s.time, s.specific_force_mps2, [&](const Step& step) { steps.push_back(step); });
  EXPECT_EQ(steps.size(), detector.steps());
  return steps;
}

TEST(StepDetector, CountsAtAnyFrequencyAndAmplitude) {
  for (const double hz : {1.2, 1.8, 2.6})
    for (const double bounce : {1.2, 3.0, 8.0})
      for (const double rate : {50.0, 100.0, 200.0}) {
        PhoneWalkOptions o;
        o.step_hz = hz;
        o.bounce_mps2 = bounce;
        o.rate_hz = rate;
        const auto steps = steps_of(walk_phone(o).samples);
        EXPECT_NEAR(double(steps.size()), o.steps, 1.0) << hz << ' ' << bounce << ' ' << rate;
        for (std::size_t i = 5; i + 5 < steps.size(); ++i)
          EXPECT_NEAR(steps[i].interval_s, 1.0 / hz, 0.06);
      }
}

TEST(StepDetector, IsIndependentOfMounting) {
  PhoneWalkOptions o;
  const auto straight = steps_of(walk_phone(o).samples);
  o.q_body_phone = SO3d::exp({2.0, 1.0, -0.5});
  EXPECT_EQ(steps_of(walk_phone(o).samples).size(), straight.size());
}

TEST(StepDetector, IgnoresRestAndHandling) {
  PhoneWalkOptions o;
  o.steps = 0;
  o.rest_s = 60.0;
  EXPECT_TRUE(steps_of(walk_phone(o).samples).empty());
  // Five shakes are no walk, nor is vibration of 12 Hz.
  o.steps = 5;
  EXPECT_TRUE(steps_of(walk_phone(o).samples).empty());
  o.steps = 400;
  o.step_hz = 12.0;
  EXPECT_TRUE(steps_of(walk_phone(o).samples).empty());
}

/// Steps of an upright unit with this vertical acceleration, at 100 Hz.
template <class Acceleration>
std::vector<Step> steps_of_vertical(double duration_s, Acceleration acceleration) {
  MargRecording samples;
  for (int i = 0; i < static_cast<int>(duration_s * 100.0); ++i) {
    MargSample s;
    s.time = LogTime::from_nanoseconds(std::int64_t{10'000'000} * (i + 1));
    s.specific_force_mps2 = {0.0, 0.0, 9.80665 + acceleration(0.01 * (i + 1))};
    samples.push_back(s);
  }
  return steps_of(samples);
}
double wave(double hz, double t) { return std::sin(2.0 * std::numbers::pi * hz * t); }

// Thirty steps at 1.8 Hz, then a bag swinging on at the same frequency with a fifth of the
// amplitude.
TEST(StepDetector, IgnoresSwingingAfterAWalk) {
  const auto steps =
      steps_of_vertical(30.0, [](double t) { return (t < 30.0 / 1.8 ? 3.0 : 0.6) * wave(1.8, t); });
  EXPECT_NEAR(double(steps.size()), 30.0, 1.0);
}

// A swing missed within a walk, cancelled by a moving arm, counts as a step; a pause does not.
TEST(StepDetector, CountsAMissedStep) {
  const auto gap = [](double missing) {
    return steps_of_vertical(40.0, [=](double t) {
      const double step = t * 2.0;  // at 2 Hz
      return step > 30.0 && step < 30.0 + missing ? 0.0 : 3.0 * wave(2.0, t);
    });
  };
  EXPECT_NEAR(double(gap(1.0).size()), 80.0, 1.0);
  const auto steps = gap(1.0);
  for (std::size_t i = 1; i < steps.size(); ++i) {
    EXPECT_NEAR(to_seconds(steps[i].time - steps[i - 1].time), 0.5, 0.1) << i;
    EXPECT_NEAR(steps[i].interval_s, 0.5, 0.1) << i;
  }
  EXPECT_NEAR(double(gap(8.0).size()), 72.0, 1.0);
}

// From running to walking the swing falls to less than a third, and rises again.
TEST(StepDetector, FollowsFromRunningToWalkingAndBack) {
  const auto steps = steps_of_vertical(60.0, [](double t) {
    const bool runs = t < 20.0 || t > 40.0;
    return runs ? 12.0 * wave(2.5, t) : 4.0 * wave(2.0, t);
  });
  EXPECT_NEAR(double(steps.size()), 50.0 + 40.0 + 50.0, 4.0);
}

TEST(StepLength, ModelsMatchTheirFormulas) {
  const Step s{LogTime(), 0.5, 3.0, -1.0, 0.512};
  EXPECT_NEAR(ConstantStep{0.7}(s), 0.7, 1e-12);
  EXPECT_NEAR(WeinbergStep{0.5}(s), 0.5 * std::sqrt(2.0), 1e-12);  // (3 + 1)^¼ = √2
  EXPECT_NEAR(KimStep{0.5}(s), 0.4, 1e-12);                        // 0.512 = 0.8³
  EXPECT_NEAR((HeightFrequencyStep{0.3, 2.0}(s)), 0.6 * std::sqrt(2.0), 1e-12);
}

TEST(StepLength, CalibratedStepsAddUpToTheDistance) {
  const auto steps = steps_of(walk_phone({}).samples);
  for (const StepLength& model : {StepLength(KimStep{}), StepLength(ConstantStep{}),
                                  StepLength(WeinbergStep{}), StepLength(HeightFrequencyStep{})}) {
    const StepLength fitted = calibrated(model, steps, 61.0);
    double sum = 0.0;
    for (const Step& s : steps) sum += length_of(s, fitted);
    EXPECT_NEAR(sum, 61.0, 1e-9);
  }
  // The constant is the distance over the number of steps.
  EXPECT_NEAR(length_of(steps[0], calibrated(ConstantStep{}, steps, 61.0)),
              61.0 / double(steps.size()), 1e-12);
  EXPECT_EQ(length_of(Step{}, calibrated(ConstantStep{0.7}, {}, 61.0)), 0.7);
}

PedestrianParameters metre_steps() {
  PedestrianParameters p;
  p.length = ConstantStep{1.0};
  return p;
}

TEST(Pedestrian, FollowsAWalk) {
  for (const bool magnetometer : {true, false}) {
    PhoneWalkOptions o;
    if (!magnetometer) o.start_rad = 0.5 * std::numbers::pi;  // its initial heading is called north
    const PhoneWalk walk = walk_phone(o);
    auto p = metre_steps();
    p.ahrs.use_magnetometer = magnetometer;
    Pedestrian pedestrian(p);
    std::vector<OdometrySample> odometry;
    for (const auto& s : walk.samples)
      pedestrian.add(s, [&](const PedestrianPose& pose) { odometry.push_back(pose.odometry()); });
    const auto& pose = pedestrian.pose();
    EXPECT_LT((pose.position_m - walk.end).norm(), 4.0) << magnetometer;  // 5 % of 80 m
    EXPECT_NEAR(pose.heading.radians(), wrap_to_pi(walk.heading_rad), 0.15) << magnetometer;
    const OdometryTrack track(odometry);
    EXPECT_LT((track.at(pose.time)->raw().translation() - pose.position_m).norm(), 1e-9);
    EXPECT_NEAR(pedestrian.report().distance_m, double(odometry.size()), 1e-9);
  }
}

TEST(Pedestrian, CovarianceCoversTheErrorAndStaysPositive) {
  int inside = 0;
  constexpr int kRuns = 20;
  for (int run = 0; run < kRuns; ++run) {
    PhoneWalkOptions o;
    o.seed = std::uint64_t(run + 1);
    Rng rng(o.seed + 1000);
    const PhoneWalk walk = walk_phone(o);
    auto p = metre_steps();
    p.length = ConstantStep{1.0 + 0.06 * rng.normal()};
    Pedestrian pedestrian(p);
    for (const auto& s : walk.samples)
      pedestrian.add(s, [&](const PedestrianPose& pose) {
        EXPECT_GT(pose.covariance.determinant(), 0.0);
        EXPECT_TRUE(pose.covariance.isApprox(pose.covariance.transpose()));
      });
    const Eigen::Vector2d e = pedestrian.pose().position_m - walk.end;
    const Eigen::Matrix2d c = pedestrian.pose().covariance.topLeftCorner<2, 2>();
    inside += e.dot(c.inverse() * e) < 5.991 ? 1 : 0;  // 95 % of two degrees of freedom
  }
  EXPECT_GE(inside, 17);
}

// Five steps are too few for a step counter, but not with walking_step_parameters().
TEST(Pedestrian, FollowsAFewSteps) {
  PhoneWalkOptions o;
  o.steps = 5;
  const PhoneWalk walk = walk_phone(o);
  ASSERT_TRUE(steps_of(walk.samples).empty());
  Pedestrian pedestrian(metre_steps());
  for (const auto& s : walk.samples) pedestrian.add(s);
  EXPECT_NEAR(pedestrian.report().distance_m, 5.0, 1.0);
  EXPECT_LT((pedestrian.pose().position_m - walk.end).norm(), 1.2);
}

// In a pocket with any mounting: the sway axis is found.
TEST(Pedestrian, FindsTheWalkingDirectionFromTheSway) {
  for (const double turned : {-2.5, -0.9, 0.6, 1.6, 3.0}) {
    PhoneWalkOptions o;
    o.q_body_phone = SO3d::exp({0.0, 0.0, turned});
    o.sway_mps2 = 2.0;
    o.steps = 120;
    o.turn_radps = 0.0;
    const PhoneWalk walk = walk_phone(o);
    Pedestrian pedestrian(metre_steps());
    for (const auto& s : walk.samples) pedestrian.add(s);
    const double offset = pedestrian.direction().offset().radians();
    // Only the axis is determined: the sign is ambiguous here.
    EXPECT_NEAR(std::abs(std::cos(offset + turned)), 1.0, 0.02) << turned;
    EXPECT_GT(pedestrian.direction().variance_ratio(), 3.0);
  }
}

// Legs of 15 s with right-angle turns; a gyro drift of 17° per minute.
TEST(Pedestrian, StraightLegsRevealTheDrift) {
  PhoneWalkOptions o;
  o.steps = 300;
  o.turn_radps = 0.0;
  PhoneWalk walk = walk_phone(o);
  for (auto& s : walk.samples) {
    const double t = to_seconds(s.time - walk.samples.front().time);
    const bool turns = t > 10.0 && std::fmod(t, 15.0) < 1.0;
    s.angular_rate_radps.z() += 0.005 + (turns ? 0.5 * std::numbers::pi : 0.0);
  }
  auto p = metre_steps();
  p.ahrs.use_magnetometer = false;
  p.ahrs.rest_rate_density = 1e3;  // the initial rest would reveal the bias
  const auto turned = [&] {
    Pedestrian pedestrian(p);
    for (const auto& s : walk.samples) pedestrian.add(s);
    // After 174 s, eleven turns and the half turn that forward is from its opposite.
    const double squares = pedestrian.pose().heading.radians() / (0.5 * std::numbers::pi);
    return std::abs(squares - std::round(squares)) * 90.0;
  };
  EXPECT_GT(turned(), 20.0);  // drifts 48°: 42° from the next square
  p.straight.bias_sigma_radps = 0.0035;
  EXPECT_LT(turned(), 5.0);
}

TEST(StraightWalk, TheRecurringRateIsTheBiasDespiteBends) {
  StraightWalkParameters p;
  p.bias_sigma_radps = 0.01;
  StraightWalk straight(p);
  double heading = 0.0, drift = 0.0;
  for (int i = 0; i < 600; ++i) {  // 2 Hz, bends to either side a third of the time
    const double bend = i % 30 < 5 ? 0.6 : i % 30 < 10 ? -0.3 : 0.0;
    heading += 0.5 * (0.008 + bend);
    drift = straight.step(LogTime::from_nanoseconds(std::int64_t{500'000'000} * i), heading);
  }
  EXPECT_NEAR(straight.bias_radps(), 0.008, 0.001);
  EXPECT_NEAR(drift, 0.008 * 299.5, 0.3);
  // Disabled by default.
  EXPECT_EQ(StraightWalk({}).step(LogTime(), 1.0), 0.0);
}

// --- faulty input -----------------------------------------------------------------------------

struct Walked {
  Pedestrian pedestrian{metre_steps()};
  explicit Walked(const MargRecording& samples) {
    for (const auto& s : samples)
      pedestrian.add(s, [&](const PedestrianPose& pose) {
        ASSERT_TRUE(pose.position_m.allFinite() && pose.covariance.allFinite());
        ASSERT_TRUE(std::isfinite(pose.heading.radians()));
      });
  }
};

TEST(PedestrianBadInput, DropoutsNanAndLateReadingsAreReported) {
  const PhoneWalk walk = walk_phone({});
  auto samples = walk.samples;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 1000; i < samples.size(); i += 50) {
    samples[i].specific_force_mps2.x() = nan;
    samples[i + 10 < samples.size() ? i + 10 : i].angular_rate_radps.y() = nan;
    if (i % 200 == 0) samples[i - 5].time = samples[i - 7].time;
  }
  const Walked run(samples);
  const auto report = run.pedestrian.report();
  EXPECT_GT(report.ahrs.accelerometer.missing, 50U);
  EXPECT_GT(report.ahrs.gyro.missing, 50U);
  EXPECT_GT(report.ahrs.gyro.late, 10U);
  EXPECT_LT((run.pedestrian.pose().position_m - walk.end).norm(), 6.0);
}

TEST(PedestrianBadInput, AGapLosesOnlyItsSteps) {
  const PhoneWalk walk = walk_phone({});
  auto samples = walk.samples;
  const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
  samples.erase(middle, middle + 300);  // 5.4 steps
  const Walked run(samples);
  EXPECT_NEAR(double(run.pedestrian.report().steps), 80.0 - 5.4, 3.0);
}

// Tumbling in free fall for a second, a saturating impact, and walking on.
TEST(PedestrianBadInput, ContinuesAfterFreeFall) {
  const PhoneWalk walk = walk_phone({});
  auto samples = walk.samples;
  const std::size_t middle = samples.size() / 2;
  for (std::size_t i = middle; i < middle + 100; ++i) {
    samples[i].specific_force_mps2 =
        i + 5 < middle + 100 ? Eigen::Vector3d(0.1, 0.0, 0.1) : Eigen::Vector3d(300.0, -300.0, 1e9);
    samples[i].angular_rate_radps = {12.0, -9.0, 4.0};
  }
  const Walked run(samples);
  EXPECT_NEAR(double(run.pedestrian.report().steps), 80.0, 6.0);
}

TEST(PedestrianBadInput, StaysFiniteOnRandomInput) {
  Rng rng(9);
  auto samples = walk_phone({}).samples;
  for (auto& s : samples)
    for (auto* v : {&s.angular_rate_radps, &s.specific_force_mps2, &s.magnetic_field_uT}) {
      const auto kind = rng.below(20);
      if (kind == 0) *v *= 1e30;
      if (kind == 1) (*v)[static_cast<int>(rng.below(3))] = std::numeric_limits<double>::infinity();
      if (kind == 2) v->setZero();
      if (kind == 3) s.time += std::chrono::milliseconds(int(rng.below(4000)) - 2000);
    }
  const Walked run(samples);
  EXPECT_LT(run.pedestrian.pose().position_m.norm(), 300.0);
}

}  // namespace
}  // namespace wayfare
