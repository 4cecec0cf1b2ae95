#pragma once

// The map of the small room for localisation, and everything that can be observed of a localiser.

#include <memory>
#include <vector>

#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/slam/localisation.hpp>

#include "abuse/slam_support.hpp"

namespace wayfare::tests {

/// Of the walls, and at the same time of radar detections.
inline const OccupancyGrid& grid_of_room() {
  static const OccupancyGrid grid = [] {
    OccupancyGrid made;
    ScanRaster raster;
    for (int k = 0; k < 60; ++k) {
      const SE2d pose = pose_of_drive(k);
      EXPECT_TRUE(insert_scan(made, pose, scan_of_room({}, pose), {}, raster));
    }
    return made;
  }();
  return grid;
}
inline const std::shared_ptr<const LocalisationMap>& map_of_room() {
  static const auto map = LocalisationMap::make(grid_of_room(), {}, &grid_of_room()).value();
  return map;
}

inline LocalisationOptions quick_options() {
  LocalisationOptions options;
  options.min_particles = 50;
  options.min_unconverged = 100;
  options.max_particles = 300;
  options.min_candidates = 2000;
  options.max_candidates = 4000;
  options.update_travel_m = 0.05;
  return options;
}

inline Gaussian<SE2d> start_of_drive() {
  return {pose_of_drive(0), Eigen::Vector3d(0.01, 0.01, 0.01).asDiagonal()};
}

inline PointSet points_of_drive(int k) { return end_points(scan_of_drive(k)); }

inline void append(std::vector<double>& all, const LocalisationOutcome& o) {
  const SE2d& T = o.T_map_base.mean;
  all.insert(all.end(), {o.time.seconds(), T.x(), T.y(), T.rotation().cos(), T.rotation().sin()});
  for (const double c : o.T_map_base.covariance.reshaped()) all.push_back(c);
  for (const bool b : {o.converged, o.weighed, o.odometry_refused, o.searched, o.relocalised})
    all.push_back(b ? 1.0 : 0.0);
  all.insert(all.end(), {o.mass, o.agreement, static_cast<double>(o.particles),
                         static_cast<double>(o.clusters)});
}
inline std::vector<double> numbers_of(const Localiser& localiser) {
  std::vector<double> all;
  for (const PoseParticle& p : localiser.particles())
    all.insert(all.end(), {p.T_map_base.x(), p.T_map_base.y(), p.T_map_base.rotation().cos(),
                           p.T_map_base.rotation().sin(), p.weight});
  return all;
}

}  // namespace wayfare::tests
