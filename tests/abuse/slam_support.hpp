#pragma once

// A small room for the tests of SLAM and localisation: scans from any pose, and one interface to
// the systems that take a scan at a time.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/slam/graph_slam.hpp>
#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/pedestrian_slam.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::tests {

using Odometry = Transform2<frame::Odom, frame::Base>;

inline constexpr std::size_t kBeams = 120;

/// Distance to the walls of a room of 6 m × 4 m with a niche of 1 m × 1 m in a corner.
inline double distance_to_walls(const Eigen::Vector2d& from, double bearing) {
  struct Wall {
    Eigen::Vector2d a, b;
  };
  static const std::vector<Wall> walls = {
      {{0, 0}, {6, 0}}, {{6, 0}, {6, 4}}, {{6, 4}, {1, 4}},
      {{1, 4}, {1, 3}}, {{1, 3}, {0, 3}}, {{0, 3}, {0, 0}},
  };
  const Eigen::Vector2d d(std::cos(bearing), std::sin(bearing));
  double nearest = 100.0;
  for (const Wall& w : walls) {
    const Eigen::Vector2d e = w.b - w.a, f = w.a - from;
    const double cross = d.x() * e.y() - d.y() * e.x();
    if (std::abs(cross) < 1e-12) continue;
    const double range = (f.x() * e.y() - f.y() * e.x()) / cross;
    const double along = (f.x() * d.y() - f.y() * d.x()) / cross;
    if (range > 0 && along >= 0 && along <= 1) nearest = std::min(nearest, range);
  }
  return nearest;
}

inline LogTime at_seconds(double s) { return LogTime::from_seconds(s); }

/// The room from `pose`, by a laser all round at the robot's centre.
inline LaserScan scan_of_room(LogTime time, const SE2d& pose) {
  LaserScan scan{time,  Angle::degrees(-180),      Angle::degrees(360.0 / kBeams), 0.05F,
                 20.0F, std::vector<float>(kBeams)};
  for (std::size_t i = 0; i < kBeams; ++i)
    scan.ranges_m[i] = static_cast<float>(distance_to_walls(
        pose.translation(), pose.heading().radians() + scan.bearing(i).radians()));
  return scan;
}

/// The k-th pose of a drive round the room, five scans a second at 0.6 m/s.
inline SE2d pose_of_drive(int k) {
  const double phase = 0.1 * k;
  return SE2d(3.0 + 1.4 * std::cos(phase), 1.6 + 0.7 * std::sin(phase),
              Angle::radians(phase + 0.5 * std::numbers::pi));
}
inline LogTime time_of_drive(int k) { return at_seconds(10.0 + 0.2 * k); }
inline LaserScan scan_of_drive(int k) { return scan_of_room(time_of_drive(k), pose_of_drive(k)); }
inline std::optional<Odometry> odometry_of_drive(int k) { return Odometry(pose_of_drive(k)); }

/// As numbers without rounding.
inline std::vector<double> numbers_of(const Trajectory& path) {
  std::vector<double> all;
  for (const StampedPose& p : path) {
    const SE2d T = p.T_map_base.raw();
    all.insert(all.end(), {p.time.seconds(), T.x(), T.y(), T.rotation().cos(), T.rotation().sin()});
  }
  return all;
}
inline bool all_finite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}
inline void append(std::vector<double>& all, const OccupancyGrid& map) {
  map.for_each_tile([&](const Cell& corner, std::span<const std::int16_t> cells) {
    all.insert(all.end(), {static_cast<double>(corner.x), static_cast<double>(corner.y)});
    all.insert(all.end(), cells.begin(), cells.end());
  });
}

/// One interface to the systems that take a scan at a time; `numbers()` is what can be observed,
/// the poses first.
template <class Slam, class OptionsOfSlam>
struct DriverOf {
  using Options = OptionsOfSlam;
  explicit DriverOf(const Options& options = {}) : slam(options) {}
  [[nodiscard]] Trajectory trajectory() const { return slam.trajectory(); }
  [[nodiscard]] OccupancyGrid map() const { return slam.map(); }
  [[nodiscard]] std::size_t scans() const { return slam.statistics().scans; }
  [[nodiscard]] std::size_t unmatched() const { return slam.statistics().unmatched_scans; }
  Slam slam;
};

struct GraphDriver : DriverOf<GraphSlam, GraphSlamOptions> {
  using DriverOf::DriverOf;
  Result<ScanOutcome> add(const LaserScan& scan, const std::optional<Odometry>& odometry) {
    return slam.add_scan(scan, odometry);
  }
  Result<void> finish() { return slam.finish(); }
  static auto run(const Recording& r, const SlamProgress& p = {}) {
    return run_graph_slam(r, {}, p);
  }
};

struct HectorDriver : DriverOf<HectorSlam, HectorSlamOptions> {
  using DriverOf::DriverOf;
  Result<ScanOutcome> add(const LaserScan& scan, const std::optional<Odometry>& odometry) {
    return slam.add_scan(scan, odometry);
  }
  Result<void> finish() { return {}; }
  static auto run(const Recording& r, const SlamProgress& p = {}) {
    return run_hector_slam(r, {}, p);
  }
};

struct SubmapDriver : DriverOf<SubmapSlam, SubmapSlamOptions> {
  using DriverOf::DriverOf;
  Result<ScanOutcome> add(const LaserScan& scan, const std::optional<Odometry>& odometry) {
    MotionHint hint;
    hint.odometry = odometry;
    return slam.add_scan(scan, hint);
  }
  Result<void> finish() { return slam.finish(); }
  static auto run(const Recording& r, const SlamProgress& p = {}) {
    return run_submap_slam(r, {}, p);
  }
};

/// Takes no odometry: it comes from the unit, here one that lies still.
struct PedestrianDriver {
  using Options = PedestrianSlamOptions;
  explicit PedestrianDriver(const Options& options = {}) : slam(options) {}
  Result<ScanOutcome> add(const LaserScan& scan, const std::optional<Odometry>& odometry) {
    if (odometry && !odometry->raw().translation().allFinite())
      return Error{ErrorCode::invalid, "a pedestrian has no odometry"};
    return slam.add_scan(scan);
  }
  Result<void> finish() { return slam.finish(); }
  [[nodiscard]] Trajectory trajectory() const { return slam.slam().trajectory(); }
  [[nodiscard]] OccupancyGrid map() const { return slam.slam().map(); }
  [[nodiscard]] std::size_t scans() const { return slam.slam().statistics().scans; }
  [[nodiscard]] std::size_t unmatched() const { return slam.slam().statistics().unmatched_scans; }
  static auto run(const Recording& r, const SlamProgress& p = {}) {
    return run_pedestrian_slam(r, {}, {}, p);
  }
  PedestrianSlam slam;
};

template <class Driver>
std::vector<double> numbers_of(const Driver& driver) {
  std::vector<double> all = numbers_of(driver.trajectory());
  append(all, driver.map());
  all.push_back(static_cast<double>(driver.scans()));
  all.push_back(static_cast<double>(driver.unmatched()));
  return all;
}

}  // namespace wayfare::tests
