#include "range_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <sstream>

#include <wayfare/io/text_file.hpp>

namespace wayfare::examples {
namespace {

template <std::size_t N>
using Rows = std::vector<std::array<double, N>>;

/// Rows of N finite numbers; the first is a time, which does not go back.
template <std::size_t N>
Result<Rows<N>> read_rows(const std::string& path) {
  const auto content = io::read_file(path);
  if (!content) return content.error();
  if (content->damage) return *content->damage;
  Rows<N> rows;
  std::istringstream lines(content->bytes);
  std::string line;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    std::istringstream fields(line);
    std::array<double, N> row;
    for (double& value : row) fields >> value;
    if (!fields || !(fields >> std::ws).eof())
      return Error{ErrorCode::parse, "expected " + std::to_string(N) + " numbers", path, number};
    if (!rows.empty() && row[0] < rows.back()[0])
      return Error{ErrorCode::parse, "the time goes back", path, number};
    rows.push_back(row);
  }
  if (rows.empty()) return Error{ErrorCode::parse, "contains no line", path};
  return rows;
}

struct Circle {
  Eigen::Vector2d centre;
  double radius;
};

double cost(const std::vector<Circle>& circles, const Eigen::Vector2d& point,
            const RangeNoise& noise) {
  const RobustKernel kernel{RobustKernelKind::cauchy, noise.kernel};
  double sum = 0.0;
  for (const Circle& c : circles) {
    const double e = ((point - c.centre).norm() - c.radius) / noise.range_m;
    sum += kernel(e * e).cost;
  }
  return sum;
}

/// Of the intersections of two of the circles, that with the least cost.
Eigen::Vector2d meeting_point(const std::vector<Circle>& circles, const RangeNoise& noise) {
  Eigen::Vector2d best = circles.front().centre + Eigen::Vector2d(circles.front().radius, 0.0);
  double least = cost(circles, best, noise);
  for (std::size_t i = 0; i < circles.size(); ++i) {
    for (std::size_t j = i + 1; j < circles.size(); ++j) {
      const Circle &a = circles[i], &b = circles[j];
      const Eigen::Vector2d apart = b.centre - a.centre;
      const double d = apart.norm();
      if (!(d > 0.0)) continue;
      const double along = (a.radius * a.radius - b.radius * b.radius + d * d) / (2.0 * d);
      const double height2 = a.radius * a.radius - along * along;
      if (height2 < 0.0) continue;
      const Eigen::Vector2d u = apart / d, normal(-u.y(), u.x());
      for (const double height : {std::sqrt(height2), -std::sqrt(height2)}) {
        const Eigen::Vector2d point = a.centre + along * u + height * normal;
        const double c = cost(circles, point, noise);
        if (c < least) least = c, best = point;
      }
    }
  }
  return best;
}

}  // namespace

Result<RangeRun> read_range_run(const std::string& odometry, const std::string& ranges) {
  const auto steps = read_rows<3>(odometry);
  if (!steps) return steps.error();
  const auto heard = read_rows<4>(ranges);
  if (!heard) return heard.error();
  RangeRun run;
  for (const auto& [time, distance, heading] : *steps)
    run.steps.emplace_back(distance, 0.0, Angle::radians(heading));
  std::size_t line = 0, step = 0;
  for (const auto& [time, sender, receiver, range] : *heard) {
    ++line;
    if (!(range > 0.0)) return Error{ErrorCode::parse, "the range is not positive", ranges, line};
    while (step < steps->size() && (*steps)[step][0] < time) ++step;
    if (step == steps->size()) break;  // after the last step
    const auto number = static_cast<int>(receiver);
    const auto found = std::find(run.beacons.begin(), run.beacons.end(), number);
    const auto beacon = static_cast<int>(found - run.beacons.begin());
    if (found == run.beacons.end()) run.beacons.push_back(number);
    run.ranges.push_back({static_cast<int>(step) + 1, beacon, range});
  }
  return run;
}

RangeGraph range_graph(const RangeRun& run, bool free_scale, const RangeNoise& noise) {
  constexpr std::size_t kFirst = 100;  // ranges while odometry has not drifted much
  RangeGraph graph;
  std::vector<VariableId<SE2d>> poses{graph.add(SE2d())};
  graph.fix(poses.front());
  const Eigen::Vector3d sigma(noise.forward_m, noise.sideways_m, noise.heading_rad);
  const Eigen::Matrix3d information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  for (const SE2d& step : run.steps) {
    poses.push_back(graph.add(graph[poses.back()] * step));
    graph.add(Between<SE2d>{step, information}, poses[poses.size() - 2], poses.back());
  }
  std::vector<VariableId<Eigen::Vector2d>> beacons;
  for (std::size_t beacon = 0; beacon < run.beacons.size(); ++beacon) {
    std::vector<Circle> circles;
    for (const auto& r : run.ranges)
      if (r.beacon == static_cast<int>(beacon) && circles.size() < kFirst)
        circles.push_back(
            {graph[poses[static_cast<std::size_t>(r.pose)]].translation(), r.range_m});
    beacons.push_back(graph.add(meeting_point(circles, noise)));
  }
  const auto scale = graph.add(RangeScale(RangeScale::Zero()));
  if (!free_scale) graph.fix(scale);
  const Eigen::Matrix<double, 1, 1> weight(1.0 / (noise.range_m * noise.range_m));
  for (const auto& r : run.ranges)
    graph.add(Robust{ScaledRange{r.range_m, weight},
                     RobustKernel{RobustKernelKind::cauchy, noise.kernel}},
              poses[static_cast<std::size_t>(r.pose)], beacons[static_cast<std::size_t>(r.beacon)],
              scale);
  return graph;
}

}  // namespace wayfare::examples
