#pragma once

// Common to the particle filter's tests: a recording in a room, runs over it and their errors.

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sim/worlds.hpp>
#include <wayfare/slam/radar_slam.hpp>

namespace wayfare {

/// The first 40 s of a drive round the room at 0.25 m/s with all sensors.
inline const Recording& room() {
  static const Recording recording = [] {
    const Rng rng(1);
    const auto world = sim::make_world("room", rng);
    Recording r = sim::simulate_world(*world, sim::turtlebot(rng), rng).value();
    const LogTime end = r.truth.front().time + Duration(40'000'000'000);
    const auto cut = [&](auto& stream) {
      std::erase_if(stream, [&](const auto& sample) { return sample.time > end; });
    };
    cut(r.scans), cut(r.radar), cut(r.wheels), cut(r.gyro), cut(r.odometry), cut(r.truth);
    return r;
  }();
  return recording;
}

/// All results of a run, as numbers without rounding.
struct RunBytes {
  std::vector<double> poses, log_weights;
  std::vector<std::int16_t> lidar, radar;
  bool operator==(const RunBytes&) const = default;
};

inline std::vector<std::int16_t> bytes_of(const OccupancyGrid& map) {
  std::vector<std::int16_t> bytes;
  map.for_each_tile([&](const Cell& corner, std::span<const std::int16_t> cells) {
    bytes.push_back(static_cast<std::int16_t>(corner.x));
    bytes.push_back(static_cast<std::int16_t>(corner.y));
    bytes.insert(bytes.end(), cells.begin(), cells.end());
  });
  return bytes;
}

inline RunBytes bytes_of(const RadarSlamRun& slam) {
  RunBytes bytes{{}, slam.log_weights, bytes_of(slam.lidar_map), bytes_of(slam.radar_map)};
  for (const Trajectory* poses : {&slam.trajectory, &slam.particles})
    for (const StampedPose& p : *poses) {
      const SE2d T = p.T_map_base.raw();
      bytes.poses.insert(bytes.poses.end(), {T.x(), T.y(), T.rotation().cos(), T.rotation().sin()});
    }
  return bytes;
}

inline RadarSlamOptions few() {
  RadarSlamOptions options;
  options.particles = 8;
  return options;
}

inline RadarSlamRun run(const Recording& recording, SlamSensors sensors) {
  auto slam = run_radar_slam(recording, few(), sensors);
  EXPECT_TRUE(slam) << slam.error().to_string();
  return *std::move(slam);
}

/// Greatest distance from the truth, both starting at the same pose.
inline double largest_error_m(const Trajectory& estimate, const Recording& recording) {
  double largest = 0;
  const SE2d start = *pose_at(recording.truth, estimate.front().time);
  const SE2d T_map_truth = estimate.front().T_map_base.raw() * start.inverse();
  for (const StampedPose& p : estimate) {
    const auto truth = pose_at(recording.truth, p.time);
    if (truth)
      largest = std::max(
          largest,
          (p.T_map_base.raw().translation() - (T_map_truth * *truth).translation()).norm());
  }
  return largest;
}

inline bool says(const RadarSlamRun& slam, const std::string& what) {
  return std::any_of(slam.faults.begin(), slam.faults.end(),
                     [&](const SensorFault& f) { return f.what.find(what) != std::string::npos; });
}

}  // namespace wayfare
