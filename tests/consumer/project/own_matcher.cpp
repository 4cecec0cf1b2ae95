#include "links.hpp"

#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <wayfare/slam/basic_graph_slam.hpp>
#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/submap_slam.hpp>

namespace {

using namespace wayfare;

/// Point-to-point ICP among all points.
struct NearestPoints {
  using Map = std::vector<Eigen::Vector2d>;

  Result<Map> make_map(std::span<const PlacedPoints> scans) const {
    Map map;
    for (const PlacedPoints& scan : scans)
      for (std::size_t i = 0; i < scan.points->size(); ++i)
        map.push_back(scan.T_map_points * Eigen::Vector2d((*scan.points)[i].cast<double>()));
    return map;
  }

  Result<std::optional<MatchResult>> match(const Map& map, const PointSet& points,
                                           const SE2d& prior, const SearchWindow&,
                                           const MatchOptions&) const {
    MatchResult match{.T_map_points = prior};
    const auto n = static_cast<double>(points.size());
    for (int round = 0; round < 8; ++round) {
      Eigen::Vector2d p_sum(0, 0), q_sum(0, 0);
      double dot = 0, cross = 0, near = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector2d p = match.T_map_points * Eigen::Vector2d(points[i].cast<double>());
        double least = std::numeric_limits<double>::infinity(), x = 0, y = 0;
        for (const Eigen::Vector2d& q : map) {
          const double dx = q.x() - p.x(), dy = q.y() - p.y(), square = dx * dx + dy * dy;
          if (square < least) least = square, x = q.x(), y = q.y();
        }
        p_sum += p, q_sum += Eigen::Vector2d(x, y);
        dot += p.x() * x + p.y() * y, cross += p.x() * y - p.y() * x;
        near += least < 0.1 * 0.1 ? 1 : 0;
      }
      dot -= p_sum.dot(q_sum) / n, cross -= (p_sum.x() * q_sum.y() - p_sum.y() * q_sum.x()) / n;
      const SO2d turn(Angle::radians(std::atan2(cross, dot)));
      match.T_map_points =
          SE2d(Eigen::Vector2d((q_sum - turn * p_sum) / n), turn) * match.T_map_points;
      match.score = near / n;
    }
    return std::optional(match);
  }
};

/// A room of 6 m × 4 m with a corner cut off.
LaserScan seen_from(const SE2d& pose, double time_s) {
  LaserScan scan{LogTime::from_seconds(time_s), Angle(), Angle::degrees(2), 0.05F, 20.0F, {}};
  const double walls[5][3] = {{1, 0, 6}, {-1, 0, 0}, {0, 1, 4}, {0, -1, 0}, {0.6, 0.8, 5.6}};
  for (std::size_t i = 0; i < 180; ++i) {
    const Eigen::Vector2d beam = SO2d(pose.heading() + scan.bearing(i)) * Eigen::Vector2d(1.0, 0.0);
    double range = 20.0;
    for (const auto& [nx, ny, at] : walls) {
      const double speed = nx * beam.x() + ny * beam.y();
      if (speed > 1e-9) range = std::min(range, (at - nx * pose.x() - ny * pose.y()) / speed);
    }
    scan.ranges_m.push_back(static_cast<float>(range));
  }
  return scan;
}

/// Whether the odometry, which turns too far, is corrected: it ends 0.5 m off after 40 scans.
///
/// The beams' ends are at most 14 cm apart, and those of four scans in between: a nearest point is
/// within a few centimetres of the wall's point that was seen.
template <class Slam, class Add>
bool corrects_odometry(Slam slam, const Add& add) {
  SE2d truth(1.5, 1.0, Angle()), odometry = truth, last, by_odometry;
  for (int k = 0; k < 40; ++k) {
    last = truth;
    by_odometry = odometry;
    if (!add(slam, seen_from(truth, 0.2 * k), Transform2<frame::Odom, frame::Base>(odometry)))
      return false;
    truth = truth * SE2d(0.12, 0.0, Angle::degrees(6));
    odometry = odometry * SE2d(0.12, 0.0, Angle::degrees(6.7));  // 28° too far after 40 scans
  }
  return slam.statistics().unmatched_scans == 0 && slam.statistics().matcher_errors.count == 0 &&
         slam.trajectory().back().T_map_base.raw().minus(last).norm() < 0.08 &&
         by_odometry.minus(last).norm() > 0.3;
}

}  // namespace

bool own_matcher() {
  GraphSlamOptions graph;
  graph.local_nodes = 4;
  SubmapSlamOptions submaps;
  submaps.submap_nodes = 8;
  const auto add = [](auto& slam, const LaserScan& scan, const auto& odometry) {
    return slam.add_scan(scan, odometry).has_value();
  };
  return corrects_odometry(BasicGraphSlam(NearestPoints{}, graph), add) &&
         corrects_odometry(BasicHectorSlam(NearestPoints{}), add) &&
         corrects_odometry(BasicSubmapSlam(NearestPoints{}, submaps),
                           [](auto& slam, const LaserScan& scan, const auto& odometry) {
                             return slam.add_scan(scan, {odometry, {}}).has_value();
                           });
}
