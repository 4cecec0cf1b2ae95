#include <wayfare/slam/detail/graph_slam/local_optimiser.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace wayfare::detail {
namespace {

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool is_fixed(const PoseGraph2& graph, int pose) {
  return graph.fixed.empty() ? pose == 0
                             : std::ranges::find(graph.fixed, pose) != graph.fixed.end();
}

/// Moves all poses together to where they are nearest to those before.
void keep_place(PoseGraph2& graph, const std::vector<SE2d>& before) {
  const auto count = static_cast<Eigen::Index>(before.size());
  Eigen::Matrix2Xd from(2, count), to(2, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    from.col(k) = graph.poses[static_cast<std::size_t>(k)].translation();
    to.col(k) = before[static_cast<std::size_t>(k)].translation();
  }
  const Eigen::Matrix3d fit = Eigen::umeyama(from, to, false);
  const SE2d T_before_now(fit(0, 2), fit(1, 2), Angle::radians(std::atan2(fit(1, 0), fit(0, 0))));
  for (SE2d& pose : graph.poses) pose = T_before_now * pose;
}

}  // namespace

/// The edges of each pose.
void LocalOptimiser::link(const PoseGraph2& graph) {
  first_.assign(graph.poses.size() + 1, 0);
  for (const auto& e : graph.edges) ++first_[at(e.from) + 1], ++first_[at(e.to) + 1];
  int sum = 0;  // first_[k + 1] becomes the first entry of pose k, and with its edges the end
  for (std::size_t k = 1; k < first_.size(); ++k) sum += std::exchange(first_[k], sum);
  edges_.resize(2 * graph.edges.size());
  for (std::size_t i = 0; i < graph.edges.size(); ++i)
    for (const int pose : {graph.edges[i].from, graph.edges[i].to})
      edges_[at(first_[at(pose) + 1]++)] = static_cast<int>(i);
}

/// The free poses are those within the fewest edges that make `most`; then come those next to them.
/// False if all are free.
bool LocalOptimiser::select(const PoseGraph2& graph, std::size_t most) {
  local_.assign(graph.poses.size(), -1);
  region_.assign(1, pose_);
  local_[at(pose_)] = 0;
  std::size_t done = 0;
  free_ = 0;
  while (done < region_.size()) {
    if (region_.size() > most) {
      free_ = done;
      return true;
    }
    for (const std::size_t end = region_.size(); done < end; ++done)
      for (int i = first_[at(region_[done])]; i < first_[at(region_[done]) + 1]; ++i) {
        const auto& e = graph.edges[at(edges_[at(i)])];
        const int next = e.from == region_[done] ? e.to : e.from;
        if (local_[at(next)] >= 0) continue;
        local_[at(next)] = static_cast<int>(region_.size());
        region_.push_back(next);
      }
  }
  return false;
}

Result<void> LocalOptimiser::optimise_region(PoseGraph2& graph, const OptimiseOptions& options) {
  part_.poses.clear();
  part_.edges.clear();
  part_.fixed.clear();
  for (std::size_t k = 0; k < region_.size(); ++k) {
    const int pose = region_[k];
    part_.poses.push_back(graph.poses[at(pose)]);
    if (k >= free_ || is_fixed(graph, pose)) part_.fixed.push_back(static_cast<int>(k));
    if (k >= free_) continue;
    for (int i = first_[at(pose)]; i < first_[at(pose) + 1]; ++i) {
      const auto& e = graph.edges[at(edges_[at(i)])];
      const int other = local_[at(e.from == pose ? e.to : e.from)];
      if (other < static_cast<int>(k)) continue;  // taken at the other end
      part_.edges.push_back(e);
      part_.edges.back().from = local_[at(e.from)];
      part_.edges.back().to = local_[at(e.to)];
    }
  }
  const auto solved = optimiser_.optimise(part_, options);
  if (!solved) return solved.error();
  for (std::size_t k = 0; k < free_; ++k) graph.poses[at(region_[k])] = part_.poses[k];
  return {};
}

/// Of the free poses next to those that are not.
bool LocalOptimiser::border_has_moved(const PoseGraph2& graph,
                                      const std::vector<SE2d>& before) const {
  constexpr double kMost_m = 0.01, kMost_rad = 0.002;
  for (std::size_t k = 0; k < free_; ++k) {
    const int pose = region_[k];
    const SE2d moved = before[at(pose)].inverse() * graph.poses[at(pose)];
    if (moved.translation().norm() < kMost_m && std::abs(moved.heading().radians()) < kMost_rad)
      continue;
    for (int i = first_[at(pose)]; i < first_[at(pose) + 1]; ++i) {
      const auto& e = graph.edges[at(edges_[at(i)])];
      if (local_[at(e.from == pose ? e.to : e.from)] >= static_cast<int>(free_)) return true;
    }
  }
  return false;
}

Result<void> LocalOptimiser::optimise_whole(PoseGraph2& graph, const OptimiseOptions& options) {
  const auto solved = whole_.optimise(graph, options);
  return solved ? Result<void>() : solved.error();
}

Result<void> LocalOptimiser::optimise(PoseGraph2& graph, const OptimiseOptions& options) {
  constexpr std::size_t kFewest = 250, kGrowth = 3;
  if (pose_ == kNowhere) {
    const std::vector<SE2d> before = graph.poses;
    auto done = optimise_whole(graph, options);
    if (done) keep_place(graph, before);
    return done;
  }
  link(graph);
  const std::vector<SE2d> before = graph.poses;
  for (std::size_t most = kFewest; select(graph, most); most *= kGrowth) {
    if (auto done = optimise_region(graph, options); !done) {
      graph.poses = before;
      return done;
    }
    if (!border_has_moved(graph, before)) return {};
  }
  auto done = optimise_whole(graph, options);
  if (!done) graph.poses = before;
  return done;
}

}  // namespace wayfare::detail
