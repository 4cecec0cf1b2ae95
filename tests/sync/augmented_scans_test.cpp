#include <wayfare/sync/augmented_scans.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sim/simulate_recording.hpp>

#include "core/at.hpp"

namespace wayfare {
namespace {

using tests::at;

// A robot on a circle of 2 m at 0.5 m/s; its radar sees one fixed point, its wheels are exact.
struct Drive {
  static constexpr double kTurn = 0.25, kBase = 0.3;
  static SE2d pose(LogTime t) { return SE2d::exp({0.5 * t.seconds(), 0.0, kTurn * t.seconds()}); }

  Recording recording;
  Eigen::Vector2d target{3.0, 1.0};

  explicit Drive(double length_s = 6.0) {
    recording.wheel_base_m = kBase;
    recording.T_base_radar =
        Transform2<frame::Base, frame::Radar>(SE2d(0.1, 0.02, Angle::degrees(3)));
    const double half = 0.5 * kBase * kTurn;
    for (int i = 0; 0.05 * i <= length_s; ++i) {
      const double dt = i == 0 ? 0.0 : 0.05;
      recording.wheels.push_back({at(0.05 * i), (0.5 - half) * dt, (0.5 + half) * dt});
      recording.gyro.push_back({at(0.05 * i), i == 0 ? 0.0 : kTurn});
    }
    for (int i = 0; i / 30.0 + 0.007 <= length_s; ++i) recording.radar.push_back(frame(i));
    for (int i = 0; 0.2 * i + 0.013 <= length_s; ++i)
      recording.scans.push_back({at(0.2 * i + 0.013), {}, Angle::degrees(1), 0.1F, 3.0F, {1.0F}});
  }
  [[nodiscard]] RadarScan frame(int i) const {
    const LogTime t = at(i / 30.0 + 0.007);
    const Eigen::Vector2d p = (pose(t) * recording.T_base_radar.raw()).inverse() * target;
    return {t, {{static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F, 0.0F, 20.0F}}};
  }
  [[nodiscard]] SyncParams params() const { return sync_params(recording); }
};

TEST(AugmentedScans, FramesAlignInThePoseOfTheFirst) {
  const Drive drive;
  std::size_t scans = 0;
  for (const SyncedStep& step : synchronise(drive.recording, drive.params())) {
    if (!step.radar) continue;
    ++scans;
    EXPECT_EQ(step.radar->time, step.time);
    EXPECT_LE(step.radar->scans, 20U);
    const Eigen::Vector2d expected = Drive::pose(step.time).inverse() * drive.target;
    for (std::size_t i = 0; i < step.radar->points.size(); ++i)
      EXPECT_LT((step.radar->points[i].cast<double>() - expected).norm(), 1e-5);
  }
  EXPECT_EQ(scans, 9U);  // 180 frames in 6 s
}

TEST(AugmentedScans, StepsAtTheTimeBaseAndTheScans) {
  const Drive drive;
  const auto steps = synchronise(drive.recording, drive.params());
  std::vector<LogTime> expected;
  for (int i = 0; i <= 120; ++i) expected.push_back(at(0.05 * i));
  for (std::size_t i = 0; i < drive.recording.radar.size(); i += 20)
    expected.push_back(drive.recording.radar[i].time);
  for (const LaserScan& scan : drive.recording.scans) expected.push_back(scan.time);
  std::sort(expected.begin(), expected.end());
  ASSERT_EQ(steps.size(), expected.size());
  for (std::size_t i = 0; i < steps.size(); ++i) EXPECT_EQ(steps[i].time, expected[i]);
}

TEST(AugmentedScans, MotionIsInterpolatedWithoutLoss) {
  const Drive drive;
  double left = 0.0, right = 0.0;
  SE2d by_wheels, by_gyro;
  for (const SyncedStep& step : synchronise(drive.recording, drive.params())) {
    left += step.wheels.left_m;
    right += step.wheels.right_m;
    EXPECT_TRUE(step.wheels_known && step.gyro_known);
    by_gyro =
        by_gyro.plus({step.forward_m(), 0.0, step.gyro.turn_rate_rad_s * to_seconds(step.since)});
    if (step.since > Duration::zero()) {
      EXPECT_NEAR(step.forward_m() / to_seconds(step.since), 0.5, 1e-6);
    }
    EXPECT_LT(by_gyro.minus(Drive::pose(step.time)).norm(), 1e-6);
  }
  double all_left = 0.0, all_right = 0.0;
  for (const WheelSample& w : drive.recording.wheels) all_left += w.left_m, all_right += w.right_m;
  EXPECT_NEAR(left, all_left, 1e-12);
  EXPECT_NEAR(right, all_right, 1e-12);
}

bool same(const PointSet& a, const PointSet& b) {
  return std::equal(a.x_m().begin(), a.x_m().end(), b.x_m().begin(), b.x_m().end()) &&
         std::equal(a.y_m().begin(), a.y_m().end(), b.y_m().begin(), b.y_m().end());
}

void expect_same(const SyncedStep& a, const SyncedStep& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.wheels.left_m, b.wheels.left_m);
  EXPECT_EQ(a.wheels.right_m, b.wheels.right_m);
  EXPECT_EQ(a.gyro.turn_rate_rad_s, b.gyro.turn_rate_rad_s);
  EXPECT_EQ(a.laser.has_value(), b.laser.has_value());
  ASSERT_EQ(a.radar.has_value(), b.radar.has_value());
  if (a.radar) {
    EXPECT_TRUE(same(a.radar->points, b.radar->points));
  }
}

// Pushes the streams up to `until` in random chunks, none ahead by more than 0.3 s.
class Feeder {
 public:
  Feeder(const Recording& recording, const SyncParams& params, std::uint64_t seed)
      : recording_(recording), synchroniser_(params), rng_(seed) {}

  void run(LogTime until) {
    for (LogTime t; t < until; t += Duration(200'000'000)) {
      std::array<int, 4> order{0, 1, 2, 3};
      for (std::size_t i = 3; i > 0; --i) std::swap(order[i], order[rng_.below(i + 1)]);
      for (const int stream : order) {
        const LogTime up_to =
            std::min(until, t + Duration(200'000'000 + static_cast<int>(rng_.below(100'000'000))));
        feed(stream, up_to);
      }
    }
  }
  void finish() {
    synchroniser_.finish();
    collect();
  }
  std::vector<SyncedStep> steps;

 private:
  template <class T>
  void feed(const std::vector<T>& from, std::size_t& next, LogTime up_to) {
    for (; next < from.size() && from[next].time < up_to; ++next) {
      EXPECT_TRUE(synchroniser_.push(from[next]));
      if (rng_.below(3) == 0) collect();
    }
  }
  void feed(int stream, LogTime up_to) {
    if (stream == 0) feed(recording_.wheels, next_[0], up_to);
    if (stream == 1) feed(recording_.gyro, next_[1], up_to);
    if (stream == 2) feed(recording_.radar, next_[2], up_to);
    if (stream == 3) feed(recording_.scans, next_[3], up_to);
  }
  void collect() {
    while (auto step = synchroniser_.next()) steps.push_back(std::move(*step));
  }

  const Recording& recording_;
  RobotSynchroniser synchroniser_;
  Rng rng_;
  std::array<std::size_t, 4> next_{};
};

TEST(AugmentedScans, AnyChunksGiveTheSameSteps) {
  const Drive drive;
  const auto whole = synchronise(drive.recording, drive.params());
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Feeder feeder(drive.recording, drive.params(), seed);
    feeder.run(at(7.0));
    feeder.finish();
    ASSERT_EQ(feeder.steps.size(), whole.size());
    for (std::size_t i = 0; i < whole.size(); ++i) expect_same(feeder.steps[i], whole[i]);
  }
}

// Steps delivered by some time do not depend on later measurements.
TEST(AugmentedScans, StepsAreCausal) {
  const Drive drive;
  const auto whole = synchronise(drive.recording, drive.params());
  for (double until = 0.1; until < 6.0; until += 0.37) {
    Feeder feeder(drive.recording, drive.params(), 5);
    feeder.run(at(until));
    ASSERT_LE(feeder.steps.size(), whole.size());
    for (std::size_t i = 0; i < feeder.steps.size(); ++i) {
      expect_same(feeder.steps[i], whole[i]);
      if (feeder.steps[i].radar) {
        EXPECT_LT(feeder.steps[i].radar->until, at(until));
      }
    }
    // No step is delayed by more than one augmented scan, max_wait and a chunk.
    if (until > 2.0) {
      EXPECT_GT(feeder.steps.back().time, at(until - 2.0));
    }
  }
}

TEST(AugmentedScans, ASilentRadarDoesNotStopTheSteps) {
  Drive drive(20.0);
  auto& radar = drive.recording.radar;
  std::erase_if(radar, [](const RadarScan& s) { return s.time > at(3.0) && s.time < at(13.0); });
  const auto steps = synchronise(drive.recording, drive.params());
  double longest_s = 0.0;
  for (const SyncedStep& step : steps) {
    longest_s = std::max(longest_s, to_seconds(step.since));
    if (!step.radar) continue;
    EXPECT_TRUE(step.radar->until < at(3.1) || step.time > at(12.9));
    EXPECT_LT(to_seconds(step.radar->until - step.radar->time), 1.0);
  }
  EXPECT_LE(longest_s, 0.0500001);
  Feeder feeder(drive.recording, drive.params(), 1);
  feeder.run(at(8.0));
  EXPECT_GT(feeder.steps.back().time, at(7.0)) << "steps come while the radar is silent";
}

TEST(AugmentedScans, ASilentLaserOrGyroDoesNotStopTheSteps) {
  Drive drive;
  drive.recording.scans.clear();
  drive.recording.gyro.clear();
  Feeder feeder(drive.recording, drive.params(), 1);
  feeder.run(at(5.0));
  ASSERT_FALSE(feeder.steps.empty());
  EXPECT_GT(feeder.steps.back().time, at(3.5));
  for (const SyncedStep& step : feeder.steps) {
    EXPECT_FALSE(step.gyro_known);
    EXPECT_EQ(step.gyro.turn_rate_rad_s, 0.0);
  }
}

TEST(AugmentedScans, NonFiniteSamplesAreRejectedAndTheirIntervalUnknown) {
  Drive drive;
  drive.recording.gyro[40].turn_rate_rad_s = std::numeric_limits<double>::quiet_NaN();
  drive.recording.wheels[60].left_m = std::numeric_limits<double>::infinity();
  for (const SyncedStep& step : synchronise(drive.recording, drive.params())) {
    const double from = step.time.seconds() - to_seconds(step.since), to = step.time.seconds();
    const bool first = step.since == Duration::zero();
    EXPECT_TRUE(std::isfinite(step.gyro.turn_rate_rad_s + step.wheels.left_m));
    const auto within = [&](double a, double b) { return to > a + 1e-9 && from < b - 1e-9; };
    if (first) continue;
    EXPECT_EQ(step.gyro_known, !within(1.95, 2.0)) << to;
    EXPECT_EQ(step.wheels_known, !within(2.95, 3.0)) << to;
  }
}

TEST(AugmentedScans, LateAndDuplicateMeasurementsAreRejected) {
  RobotSynchroniser synchroniser({.wheel_base_m = 0.3});
  EXPECT_TRUE(synchroniser.push(WheelSample{at(1.0), 0.0, 0.0}));
  EXPECT_FALSE(synchroniser.push(WheelSample{at(1.0), 0.0, 0.0}));
  EXPECT_FALSE(synchroniser.push(WheelSample{at(0.9), 0.0, 0.0}));
  EXPECT_TRUE(synchroniser.push(RadarScan{at(1.0), {}}));
  EXPECT_FALSE(synchroniser.push(RadarScan{at(1.0), {}}));
  EXPECT_EQ(synchroniser.statistics().refused_late, 3U);
}

// Points with the bearing error of their Doppler bins align as exact ones do; without the array's
// largest speed they do not.
TEST(AugmentedScans, BearingsAreCorrectedForTheRobotsMotion) {
  Drive drive(2.0);  // the target stays ahead
  constexpr double kBin = 0.15, kMax = 0.96;
  // Two transmitters by four receivers: 4 · 3 / (4 · 16 − 1) of a step of π δv / 2 v_max, over π.
  constexpr double kSinePerSpeed = 4.0 / 21.0 / (2.0 * kMax);
  for (RadarScan& scan : drive.recording.radar) {
    RadarPoint& p = scan.points.front();
    const double range = std::hypot(p.x_m, p.y_m), sine = p.y_m / range;
    // The radar's speed over ground with its lever arm from a base that moves straight ahead.
    const SE2d& mount = drive.recording.T_base_radar.raw();
    const Eigen::Vector2d v =
        mount.rotation().inverse() *
        Eigen::Vector2d(0.5 - Drive::kTurn * mount.y(), Drive::kTurn * mount.x());
    const double radial = -(v.x() * p.x_m + v.y() * p.y_m) / range;
    p.doppler_m_s = static_cast<float>(kBin * std::round(radial / kBin));
    const double wrong = sine + kSinePerSpeed * (radial - p.doppler_m_s);
    p.x_m = static_cast<float>(range * std::sqrt(1.0 - wrong * wrong));
    p.y_m = static_cast<float>(range * wrong);
  }
  const auto farthest = [&] {
    double worst = 0.0;
    for (const SyncedStep& step : synchronise(drive.recording, drive.params())) {
      if (!step.radar) continue;
      const Eigen::Vector2d expected = Drive::pose(step.time).inverse() * drive.target;
      for (std::size_t i = 0; i < step.radar->points.size(); ++i)
        worst = std::max(worst, (step.radar->points[i].cast<double>() - expected).norm());
    }
    return worst;
  };
  EXPECT_GT(farthest(), 0.005);  // a third of a bin at 2 m and more
  drive.recording.radar_max_speed_m_s = kMax;
  EXPECT_LT(farthest(), 5e-4);  // the expected speed is that of the bearing before
}

TEST(AugmentedScans, AnEmptyRecordingHasNoSteps) { EXPECT_TRUE(synchronise({}, {}).empty()); }

TEST(AugmentedScans, PointsOfAnotherRadialSpeedMove) {
  const RadarArray array{.max_speed_m_s = 1.0};
  const Eigen::Vector2d velocity(0.3, 0.0);
  const auto moves = [&](float doppler) {
    return is_moving({.x_m = 2.0F, .y_m = 0.0F, .doppler_m_s = doppler}, velocity, array, 0.18);
  };
  EXPECT_FALSE(moves(-0.3F));
  EXPECT_FALSE(moves(-0.4F));
  EXPECT_TRUE(moves(0.0F));
  EXPECT_TRUE(moves(0.6F));
  EXPECT_FALSE(moves(1.7F));  // wraps
  EXPECT_FALSE(moves(std::numeric_limits<float>::quiet_NaN()));
}

}  // namespace
}  // namespace wayfare
