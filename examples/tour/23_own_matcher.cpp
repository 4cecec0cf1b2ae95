// Graph, submap and Hector SLAM of two rooms by a matcher of one's own: hill climbing in a table.
#include <cmath>
#include <cstdio>
#include <map>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/slam/basic_graph_slam.hpp>
#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/submap_slam.hpp>
using namespace wayfare;

struct HillClimbing {  // on cells of 5 cm
  using Map = std::map<Cell, double>;
  Result<Map> make_map(std::span<const PlacedPoints> scans) const {
    Map map;
    for (const auto& [points, pose] : scans)
      for (std::size_t i = 0; i < 25 * points->size(); ++i) {  // 25 cells about each
        const Eigen::Vector2d p = pose * (*points)[i / 25].cast<double>().eval() / 0.05;
        const Cell c = cell_of(p, 1.0) + Cell{int(i) % 5 - 2, int(i) / 5 % 5 - 2};
        const Eigen::Vector2d off = Eigen::Vector2d(c.x + 0.5, c.y + 0.5) - p;
        map[c] = std::max(map[c], std::exp(-0.5 * off.squaredNorm()));
      }
    return map;
  }
  static MatchResult at(const SE2d& pose, const Map& map, const PointSet& points) {
    MatchResult match{.T_map_points = pose};
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto c = map.find(cell_of(pose * points[i].cast<double>().eval(), 0.05));
      if (c != map.end()) match.score += c->second / static_cast<double>(points.size());
    }
    return match;
  }
  Result<std::optional<MatchResult>> match(const Map& map, const PointSet& points,
                                           const SE2d& prior, const SearchWindow&,
                                           const MatchOptions&) const {
    MatchResult best = at(prior, map, points);
    for (double step = 0.08; step > 0.002; step /= 2)
      for (int k = 0, tried = 0; tried < 6; k = (k + 1) % 6, ++tried) {
        const Eigen::Vector3d direction = (k < 3 ? step : -step) * Eigen::Vector3d::Unit(k % 3);
        const MatchResult next = at(best.T_map_points.plus(direction), map, points);
        if (next.score > best.score) best = next, tried = 0;
      }
    return std::optional(best);
  }
};
int main() {
  const char* plan =
      "metres_per_character 0.5\nroute a b c b a\npicture\n##############\n#     #      #\n"
      "# a          #\n#         b  #\n#     #      #\n#     #   c  #\n##############\n";
  const auto rooms = sim::read_plan(plan, "rooms").value();
  sim::RobotParams robot;
  robot.wheels.right_scale = 1.03;  // the odometry turns
  const auto run = sim::simulate_recording(rooms.plan, rooms.route_m, robot, Rng(1)).value();
  for (const Trajectory& t : {run_graph_slam(run.recording, HillClimbing{}).value().trajectory,
                              run_submap_slam(run.recording, HillClimbing{}).value().trajectory,
                              run_hector_slam(run.recording, {}, HillClimbing{}).value().trajectory,
                              as_trajectory(run.recording.odometry)})
    std::printf("%.3f m off\n", eval::absolute_error(t, run.truth).translation_m.rmse);
}
