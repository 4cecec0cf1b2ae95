#include "edge_check.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace wayfare {
namespace {

/// The true pose of each node; nothing where no scan has its pose.
std::vector<const SE2d*> node_truths(const PoseGraph2& graph, const Trajectory& estimate,
                                     const std::vector<SE2d>& truth) {
  constexpr double kSame_m = 1e-7;
  std::multimap<double, std::size_t> by_x;
  for (std::size_t i = 0; i < estimate.size(); ++i)
    by_x.emplace(estimate[i].T_map_base.raw().x(), i);
  std::vector<const SE2d*> result;
  for (const SE2d& pose : graph.poses) {
    const SE2d* found = nullptr;
    for (auto at = by_x.lower_bound(pose.x() - kSame_m);
         at != by_x.end() && at->first < pose.x() + kSame_m; ++at)
      if (pose.minus(estimate[at->second].T_map_base.raw()).norm() < kSame_m)
        found = &truth[at->second];
    result.push_back(found);
  }
  return result;
}

}  // namespace

double EdgeErrors::mean() const {
  return std::accumulate(chi2.begin(), chi2.end(), 0.0) /
         static_cast<double>(std::max<std::size_t>(1, chi2.size()));
}

double EdgeErrors::median() const {
  if (chi2.empty()) return 0.0;
  std::vector<double> sorted = chi2;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

std::size_t EdgeErrors::above(double limit) const {
  return static_cast<std::size_t>(
      std::ranges::count_if(chi2, [limit](double c) { return c > limit; }));
}

EdgeErrors edge_errors(const PoseGraph2& graph, bool robust, const Trajectory& estimate,
                       const Trajectory& truth) {
  std::vector<SE2d> true_poses;
  for (const StampedPose& p : truth) true_poses.push_back(p.T_map_base.raw());
  const std::vector<const SE2d*> nodes = node_truths(graph, estimate, true_poses);
  EdgeErrors result;
  for (const PoseEdge<SE2d>& e : graph.edges) {
    const SE2d* from = nodes[static_cast<std::size_t>(e.from)];
    const SE2d* to = nodes[static_cast<std::size_t>(e.to)];
    if (e.robust != robust || from == nullptr || to == nullptr) continue;
    const auto error = PoseError<SE2d>::error(e.measurement, *from, *to);
    result.chi2.push_back(error.dot(e.information * error));
  }
  return result;
}

}  // namespace wayfare
