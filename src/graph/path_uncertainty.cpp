#include <wayfare/graph/path_uncertainty.hpp>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <wayfare/core/contract.hpp>

namespace wayfare {

/// Links sorted by their poses, of one pose in the order of the edges.
void PathUncertaintyFinder::take_in_new(const PoseGraph2& graph) {
  WAYFARE_EXPECTS(graph.edges.size() >= edges_, "edges may only be appended");
  const std::size_t poses = graph.poses.size(), edges = graph.edges.size();
  known_.resize(edges, Use::unasked);
  edge_covariance_.resize(edges);
  if (edges == edges_ && first_.size() == poses + 1) return;
  edges_ = edges;
  const auto next = [&](int pose) -> int& { return first_[static_cast<std::size_t>(pose) + 1]; };
  first_.assign(poses + 1, 0);
  for (const auto& e : graph.edges) ++next(e.from), ++next(e.to);
  int sum = 0;  // first_[k + 1] becomes the first link of pose k, and with the links its end
  for (std::size_t k = 0; k < poses; ++k) sum += std::exchange(first_[k + 1], sum);
  links_.resize(2 * edges);
  for (std::size_t k = 0; k < edges; ++k) {
    const auto& e = graph.edges[k];
    links_[static_cast<std::size_t>(next(e.from)++)] = {e.to, static_cast<int>(k)};
    links_[static_cast<std::size_t>(next(e.to)++)] = {e.from, static_cast<int>(k)};
  }
}

bool PathUncertaintyFinder::has_covariance(const PoseGraph2& graph, std::size_t edge) {
  if (known_[edge] == Use::unasked) {
    edge_covariance_[edge] = graph.edges[edge].information.inverse();
    const bool positive = edge_covariance_[edge].llt().info() == Eigen::Success;
    known_[edge] = positive ? Use::yes : Use::no;
  }
  return known_[edge] == Use::yes;
}

void PathUncertaintyFinder::reset_result(std::size_t poses, int root) {
  result_.covariance.assign(poses, Eigen::Matrix3d::Zero());
  result_.size.assign(poses, std::numeric_limits<double>::infinity());
  result_.size[static_cast<std::size_t>(root)] = 0.0;
  open_.assign(1, {0.0, root});
  use_.assign(edges_, Use::unasked);
}

void PathUncertaintyFinder::offer(int pose, const Eigen::Matrix3d& covariance) {
  const auto to = static_cast<std::size_t>(pose);
  const double size = covariance(0, 0) + covariance(1, 1) +
                      PathUncertainty::kLever_m * PathUncertainty::kLever_m * covariance(2, 2);
  if (!(size < result_.size[to])) return;
  result_.size[to] = size;
  result_.covariance[to] = covariance;
  open_.emplace_back(size, pose);
  std::push_heap(open_.begin(), open_.end(), std::greater<>());
}

}  // namespace wayfare
