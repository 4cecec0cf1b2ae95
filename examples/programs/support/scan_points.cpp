#include "scan_points.hpp"

#include <cmath>
#include <set>
#include <utility>

#include <wayfare/sensors/point_set.hpp>

namespace wayfare::examples {
namespace {

/// Calls place(measurement, pose) for those of the choice that have a pose; returns their number.
template <class Measurement, class Place>
std::size_t for_each_placed(const std::vector<Measurement>& all, const Trajectory& path,
                            const ScanChoice& choice, std::size_t most, const Place& place) {
  std::size_t count = 0;
  for (const Measurement& m : all) {
    if (m.time < choice.from) continue;
    if (m.time > choice.until || count == most) break;
    const auto pose = pose_at(path, m.time);
    if (!pose) continue;
    place(m, *pose);
    ++count;
  }
  return count;
}

}  // namespace

ScanPoints place_scans(const Recording& recording, const Trajectory& path,
                       const ScanChoice& choice) {
  ScanPoints placed;
  placed.scans = for_each_placed(
      recording.scans, path, choice, choice.scans, [&](const LaserScan& scan, const SE2d& pose) {
        const PointSet points = end_points(scan, recording.T_base_laser.raw());
        for (std::size_t i = 0; i < points.size(); ++i)
          placed.lidar_m.emplace_back(pose * Eigen::Vector2d(points[i].cast<double>()));
      });
  placed.frames = for_each_placed(
      recording.radar, path, choice, choice.frames, [&](const RadarScan& frame, const SE2d& pose) {
        const SE2d T_map_radar = pose * recording.T_base_radar.raw();
        for (const RadarPoint& p : frame.points) {
          const Eigen::Vector2d at = T_map_radar * Eigen::Vector2d(p.x_m, p.y_m);
          if (at.allFinite()) placed.radar_m.push_back(at);
        }
      });
  return placed;
}

io::Series points_series(std::string name, std::span<const Eigen::Vector2d> points_m,
                         double spacing_m) {
  io::Series series{std::move(name), {}, {}, io::Mark::fine_points};
  std::set<std::pair<double, double>> taken;
  for (const Eigen::Vector2d& p : points_m) {
    if (!taken.emplace(std::floor(p.x() / spacing_m), std::floor(p.y() / spacing_m)).second)
      continue;
    series.add(p.x(), p.y());
  }
  return series;
}

}  // namespace wayfare::examples
