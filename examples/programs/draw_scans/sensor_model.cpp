#include "sensor_model.hpp"

#include <cmath>
#include <utility>

#include <wayfare/map/detail/scan_raster.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/slam/localisation.hpp>
#include <wayfare/slam/radar_slam.hpp>

namespace wayfare::examples {
namespace {

constexpr double kRange_m = 2.0, kFar_m = 3.0;

/// Occupancy of the cells along the x axis; in steps, as the cells are.
io::Series along_beam(const char* name, const OccupancyGrid& map) {
  io::Series series{name, {}, {}};
  for (double x = 0.005; x < kFar_m; x += 0.01)
    series.add(x, map.probability(cell_of(Eigen::Vector2d(x, 0.0), map.resolution_m())));
  return series;
}

OccupancyGrid detections(const RadarSlamOptions& o, int count) {
  OccupancyGrid map(o.radar.grid);
  const Cell at = cell_of(Eigen::Vector2d(kRange_m, 0.0), map.resolution_m());
  for (int i = 0; i < count; ++i)
    map.update(at, LogOdds::from_probability(o.radar_hit_probability));
  return map;
}

Result<io::Plot> inverse_models(const RadarSlamOptions& o) {
  OccupancyGrid beam(o.lidar.grid);
  const LaserScan scan{LogTime(), Angle(), Angle::degrees(1.0),
                       0.0F,      100.0F,  {static_cast<float>(kRange_m)}};
  ScanRaster raster;
  if (auto done = insert_scan(beam, SE2d(), scan, o.lidar_model, raster); !done)
    return done.error();
  io::Plot plot{"Inverse sensor models: a return at 2 m",
                "distance from the sensor [m]",
                "probability of occupancy",
                {}};
  plot.series = {along_beam("LiDAR, one beam", beam),
                 along_beam("radar, one detection", detections(o, 1)),
                 along_beam("radar, 20 detections", detections(o, 20))};
  return plot;
}

/// p of a point over its distance from the wall, relative to one on it.
io::Series likelihood(const char* name, const LikelihoodField& field) {
  io::Series series{name, {}, {}};
  const auto p = [&](double x) {
    return field.log_likelihood(cell_of(Eigen::Vector2d(x, 0.0), field.resolution_m()));
  };
  for (double x = -0.6; x <= 0.6; x += 0.01) series.add(x, std::exp(p(x) - p(0.001)));
  return series;
}

/// A wall on the y axis, `returns` hits in each of its cells, with free space around it.
OccupancyGrid wall(const OccupancyGridOptions& options, LogOdds hit, int returns) {
  OccupancyGrid map(options);
  const int reach = static_cast<int>(2.0 / options.resolution_m);
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x)
      if (x != 0) map.update({x, y}, LogOdds::from_probability(0.2));
    for (int i = 0; i < returns; ++i) map.update({0, y}, hit);
  }
  return map;
}

Result<io::Plot> likelihoods(const RadarSlamOptions& o) {
  PointSet points;
  for (double x = -1.0; x <= 1.0; x += 0.01) points.push_back({static_cast<float>(x), 0.0F});
  const LogOdds lidar_hit = LogOdds::from_probability(o.lidar_model.p_hit),
                radar_hit = LogOdds::from_probability(o.radar_hit_probability);
  LikelihoodField lidar, radar;
  const OccupancyGrid lidar_wall = wall(o.lidar.grid, lidar_hit, 10);
  if (auto ok = OccupancyFieldMaker().make(lidar_wall, points, SE2d(), {}, o.lidar.field, lidar);
      !ok)
    return ok.error();
  OccupancyGrid reflector(o.radar.grid);
  const auto most = static_cast<int>(o.radar.density->max_detections);
  for (int i = 0; i < 4 * most; ++i) reflector.update({0, 0}, radar_hit);
  if (auto ok = DetectionFieldMaker().make(reflector, points, SE2d(), {}, *o.radar.density, radar);
      !ok)
    return ok.error();
  const auto known = LocalisationMap::make(lidar_wall);
  if (!known) return known.error();
  io::Plot plot{"Likelihood of a point over its distance from a wall or reflector",
                "distance [m]",
                "p, relative to a point on it",
                {}};
  plot.series = {likelihood("LiDAR, particle filter", lidar),
                 likelihood("radar, particle filter", radar),
                 likelihood("LiDAR, localisation", (*known)->fields(RangeSensor::lidar).sharp)};
  return plot;
}

}  // namespace

Result<std::array<io::Plot, 2>> sensor_models() {
  const RadarSlamOptions options;
  auto inverse = inverse_models(options);
  if (!inverse) return inverse.error();
  auto forward = likelihoods(options);
  if (!forward) return forward.error();
  return std::array{*std::move(inverse), *std::move(forward)};
}

}  // namespace wayfare::examples
