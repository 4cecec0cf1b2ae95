#include <wayfare/graph/path_uncertainty.hpp>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <wayfare/core/contract.hpp>

namespace wayfare {

void PathUncertaintyFinder::take_in_new(const PoseGraph2& graph) {
  WAYFARE_EXPECTS(graph.edges.size() >= edge_covariance_.size(), "edges may only be appended");
  neighbours_.resize(std::max(graph.poses.size(), neighbours_.size()));
  for (std::size_t k = edge_covariance_.size(); k < graph.edges.size(); ++k) {
    const auto& e = graph.edges[k];
    neighbours_[static_cast<std::size_t>(e.from)].push_back({e.to, static_cast<int>(k)});
    neighbours_[static_cast<std::size_t>(e.to)].push_back({e.from, static_cast<int>(k)});
    edge_covariance_.emplace_back(e.information.inverse());
    if (edge_covariance_.back().llt().info() != Eigen::Success)
      edge_covariance_.back().setConstant(std::numeric_limits<double>::quiet_NaN());  // no offer
  }
}

void PathUncertaintyFinder::reset_result(std::size_t poses, int root) {
  result_.covariance.assign(poses, Eigen::Matrix3d::Zero());
  result_.size.assign(poses, std::numeric_limits<double>::infinity());
  result_.size[static_cast<std::size_t>(root)] = 0.0;
  open_.assign(1, {0.0, root});
  use_.assign(edge_covariance_.size(), Use::unasked);
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
