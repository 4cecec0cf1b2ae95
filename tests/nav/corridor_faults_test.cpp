// Faults in corridors: gates reject them, the filter recovers, the report lists them.

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include <wayfare/nav/corridor_ins.hpp>

#include <wayfare/sim/simulate_recording.hpp>

#include "corridor_ins/evaluate.hpp"

namespace wayfare {
namespace {

using examples::Aiding;

/// One long corridor for two minutes of driving.
sim::CorridorDriveParams params_of() {
  sim::CorridorDriveParams p;
  p.place.lengths_m = {80.0, 10.0, 10.0};
  p.pattern = sim::MotionPattern::curved;
  p.rest_s = 30.0;
  p.speed_m_s = 0.6;
  return p;
}

struct Fault {
  CorridorRun run;
  sim::CorridorDrive drive;

  [[nodiscard]] double error_m(double seconds) const {
    for (const CorridorEpoch& e : run.epochs)
      if (e.time.seconds() >= seconds) return error_of(e);
    return error_of(run.epochs.back());
  }
  [[nodiscard]] double error_of(const CorridorEpoch& e) const {
    return (e.pose.translation() - sim::true_pose_at(drive.recording.truth, e.time).translation())
        .norm();
  }
  /// Largest position error in standard deviations.
  [[nodiscard]] double worst_sigmas(double from_s) const {
    double worst = 0.0;
    for (const CorridorEpoch& e : run.epochs) {
      if (e.time.seconds() < from_s) continue;
      const double sigma = std::sqrt(e.pose_covariance(0, 0) + e.pose_covariance(1, 1));
      worst = std::max(worst, error_of(e) / sigma);
    }
    return worst;
  }
  [[nodiscard]] bool has_event(const std::string& what) const {
    return std::any_of(run.report.events.begin(), run.report.events.end(),
                       [&](const auto& event) { return event.what == what; });
  }
};

using Spoil = std::function<void(Recording&)>;
Fault drive_with(const Spoil& spoil, sim::CorridorDriveParams p = params_of()) {
  auto drive = sim::simulate_corridors(p, Rng(21));
  EXPECT_TRUE(drive);
  spoil(drive->recording);
  auto run = run_corridor_ins(drive->recording, motion_of(drive->recording),
                              examples::options_for(p, Aiding::side_walls));
  EXPECT_TRUE(run);
  return {*std::move(run), *std::move(drive)};
}

bool within(LogTime time, double from_s, double to_s) {
  return time.seconds() >= from_s && time.seconds() < to_s;
}

TEST(CorridorFaults, BridgesSixtySecondsWithoutWalls) {
  const Fault f = drive_with([](Recording& r) {
    for (LaserScan& s : r.scans)
      if (within(s.time, 80, 140)) std::fill(s.ranges_m.begin(), s.ranges_m.end(), 0.0F);
  });
  EXPECT_NEAR(to_seconds(f.run.report.longest_outage), 60.0, 0.5);
  EXPECT_LT(f.error_m(139.9), 1.0);
  EXPECT_LT(f.worst_sigmas(30), 5.0);
  // The same walls are visible afterwards.
  EXPECT_GT(f.run.report.scans_used, f.run.report.scans - 60 * 5 - 200);
  EXPECT_LT(std::abs(f.run.epochs.back().gyro_bias.value -
                     examples::true_bias_at(f.drive, f.run.epochs.back().time)),
            3 * f.run.epochs.back().gyro_bias.sigma);
}

/// Adds a plate to every scan: ranges to it where it is nearer.
void show_plate(Recording& r, double from_s, double to_s,
                const std::function<std::pair<Eigen::Vector2d, Eigen::Vector2d>(double)>& plate) {
  for (LaserScan& s : r.scans) {
    if (!within(s.time, from_s, to_s)) continue;
    const auto [a, b] = plate(s.time.seconds() - from_s);
    const auto plan = sim::FloorPlan::from_segments({{a, b}});
    for (std::size_t i = 0; i < s.ranges_m.size(); ++i) {
      const double bearing = s.bearing(i).radians();
      const double range = plan->cast({0, 0}, {std::cos(bearing), std::sin(bearing)}, 80.0);
      if (range < static_cast<double>(s.ranges_m[i])) s.ranges_m[i] = static_cast<float>(range);
    }
  }
}

TEST(CorridorFaults, ACartAlongsideIsNoWall) {
  const Fault f = drive_with([](Recording& r) {
    // Its side hides the left wall and approaches while rotating.
    show_plate(r, 80, 100, [](double t) {
      const double y = 0.75 - 0.01 * t, turn = 0.004 * t;
      return std::pair{Eigen::Vector2d(-1.0, y), Eigen::Vector2d(5.0, y + 6.0 * turn)};
    });
  });
  EXPECT_LT(f.error_m(100), 0.1);
  EXPECT_LT(f.worst_sigmas(30), 5.0);
}

TEST(CorridorFaults, WallsThatAreNotParallelAreNoCorridor) {
  const Fault f = drive_with([](Recording& r) {
    show_plate(r, 80, 100, [](double) {
      return std::pair{Eigen::Vector2d(-0.5, 0.6), Eigen::Vector2d(6.0, 0.95)};
    });
  });
  EXPECT_LT(f.error_m(100), 0.1);
  EXPECT_LT(f.worst_sigmas(30), 5.0);
}

TEST(CorridorFaults, ASaturatedGyroIsNotUsed) {
  const Fault f = drive_with([](Recording& r) {
    for (GyroSample& g : r.gyro)
      if (within(g.time, 90, 90.4)) g.turn_rate_rad_s = 1.745;
  });
  EXPECT_EQ(f.run.report.saturated_samples, 8U);
  EXPECT_TRUE(f.has_event("gyro beyond its range"));
  EXPECT_LT(f.error_m(130), 0.3);
  EXPECT_LT(f.worst_sigmas(30), 5.0);
}

TEST(CorridorFaults, SpinningWheelsAreNotUsed) {
  const Fault f = drive_with([](Recording& r) {
    for (WheelSample& w : r.wheels)
      if (within(w.time, 90, 92)) w.left_m *= 3, w.right_m *= 3;
  });
  EXPECT_GE(f.run.report.slipping_samples, 35U);
  EXPECT_TRUE(f.has_event("wheels slip"));
  EXPECT_LT(f.error_m(130), 0.3);  // if used, two seconds of it are 2.4 m
  EXPECT_LT(f.worst_sigmas(30), 5.0);
}

TEST(CorridorFaults, BadSamplesChangeNothing) {
  CorridorIns ins;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ASSERT_TRUE(ins.add_motion({LogTime::from_seconds(1), 0.0, 0.5}));
  ASSERT_TRUE(ins.add_motion({LogTime::from_seconds(2), 0.0, 0.5}));
  const CorridorState before = ins.state();
  EXPECT_FALSE(ins.add_motion({LogTime::from_seconds(2), 0.1, 0.5}));
  EXPECT_FALSE(ins.add_motion({LogTime::from_seconds(3), nan, 0.5}));
  EXPECT_FALSE(ins.add_motion({LogTime::from_seconds(3), 0.1, nan}));
  EXPECT_EQ(ins.state().minus(before), CorridorState::Tangent::Zero());
  EXPECT_EQ(ins.report().refused_samples, 3U);
  EXPECT_TRUE(ins.add_scan({}));  // without beams
  EXPECT_FALSE(ins.add_scan({}));
  EXPECT_EQ(ins.report().scans_used, 0U);
  EXPECT_FALSE(run_corridor_ins({}, {}));
}

}  // namespace
}  // namespace wayfare
