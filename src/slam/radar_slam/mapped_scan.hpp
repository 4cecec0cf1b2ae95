#pragma once

#include <cstddef>
#include <optional>

#include <wayfare/slam/radar_slam.hpp>

#include "slam/radar_slam/wall_points.hpp"

namespace wayfare {

enum Sensor { kLidar, kRadar };

/// A scan in the maps.
struct MappedScan {
  std::size_t update;  ///< of the filter, by it; the first is 0
  Sensor sensor;
  PointSet points;                     ///< as they are matched, base frame
  std::optional<LaserScan> scan = {};  ///< of a LiDAR
};

/// Inserts scans into maps. Has scratch memory: one per thread.
class MapMaker {
 public:
  explicit MapMaker(const RadarSlamOptions& o)
      : lidar_(o.lidar_model),
        hit_(LogOdds::from_probability(o.radar_hit_probability)),
        T_base_laser_(o.T_base_laser.raw()),
        spacing_m_(o.lidar.grid.resolution_m) {}

  /// With points on the walls between the beams' ends.
  [[nodiscard]] PointSet walls_of(const LaserScan& scan) const {
    return with_walls(end_points(scan, T_base_laser_), {.spacing_m = spacing_m_});
  }

  /// Points of walls_of(), or a radar's.
  void insert(RbpfMaps& maps, const SE2d& pose, Sensor sensor, const PointSet& points) {
    if (sensor == kLidar) {
      // A scan too large for the raster is left out of the map.
      (void)insert_points<FillBetweenBeams>(maps.lidar, pose, points, lidar_, raster_,
                                            T_base_laser_.translation());
      return;
    }
    for (std::size_t i = 0; i < points.size(); ++i)
      maps.radar.update(
          cell_of(pose * Eigen::Vector2d(points[i].cast<double>()), maps.radar.resolution_m()),
          hit_);
  }
  void insert(RbpfMaps& maps, const SE2d& pose, const MappedScan& scan) {
    insert(maps, pose, scan.sensor, scan.scan ? walls_of(*scan.scan) : scan.points);
  }

 private:
  InverseLidarModel lidar_;
  LogOdds hit_;
  SE2d T_base_laser_;
  double spacing_m_;
  ScanRaster raster_;
};

}  // namespace wayfare
