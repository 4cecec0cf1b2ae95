#pragma once

// The particle filter in the small room: few particles, its motion and its detections.

#include <cstddef>
#include <vector>

#include <wayfare/slam/radar_slam.hpp>

#include "abuse/slam_support.hpp"

namespace wayfare::tests {

inline RadarSlamOptions few_particles() {
  RadarSlamOptions options;
  options.particles = 4;
  options.proposal.samples = 20;
  options.proposal.headings = 4;
  return options;
}

/// To the k-th pose of the drive.
inline Gaussian<SE2d> motion_of_drive(int k) {
  const SE2d step = pose_of_drive(k - 1).inverse() * pose_of_drive(k);
  return {step, Eigen::Vector3d(4e-4, 4e-4, 4e-4).asDiagonal()};
}

/// Every fourth beam of the laser as a detection.
inline PointSet detections_of_drive(int k) {
  const PointSet ends = end_points(scan_of_drive(k));
  PointSet some;
  for (std::size_t i = 0; i < ends.size(); i += 4) some.push_back(ends[i]);
  return some;
}
inline RadarScan radar_of_drive(LogTime time, int k) {
  RadarScan scan{time};
  const PointSet points = detections_of_drive(k);
  for (std::size_t i = 0; i < points.size(); ++i)
    scan.points.push_back({points[i].x(), points[i].y(), 0.0F, 0.0F, 20.0F});
  return scan;
}

inline std::vector<double> numbers_of(const RadarSlam& slam) {
  std::vector<double> all = numbers_of(slam.trajectory());
  append(all, slam.lidar_map());
  append(all, slam.radar_map());
  all.insert(all.end(), slam.log_weights().begin(), slam.log_weights().end());
  const RbpfStatistics& s = slam.statistics();
  for (const std::size_t n : {s.scans, s.without_points, s.updates, s.matches})
    all.push_back(static_cast<double>(n));
  return all;
}

}  // namespace wayfare::tests
