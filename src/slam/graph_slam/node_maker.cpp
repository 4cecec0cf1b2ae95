#include "slam/graph_slam/node_maker.hpp"

#include <cmath>

#include <Eigen/LU>

#include "slam/graph_slam/ambiguity.hpp"

namespace wayfare {

void NodeMaker::accumulate(const Motion& motion) {
  const Eigen::Matrix3d turn = motion.increment.inverse().adjoint();
  since_node_ = turn * since_node_ * turn.transpose() + motion.covariance();
}

bool NodeMaker::is_due(const NodeMap& nodes, const SE2d& pose) const {
  const SE2d moved = nodes.pose(nodes.latest()).inverse() * pose;
  return moved.translation().norm() > options_.node_distance_m ||
         std::abs(moved.heading().radians()) > options_.node_turn.radians();
}

void NodeMaker::add(NodeMap& nodes, const SE2d& pose, const PointSet& points,
                    const Placement& match) {
  const SE2d step = nodes.pose(nodes.latest()).inverse() * pose;
  nodes.append(pose, points, information(step, pose.rotation(), match));
  since_node_.setZero();
}

/// Information of the match, plus that of odometry along directions the match does not constrain.
Eigen::Matrix3d NodeMaker::information(const SE2d& step, const SO2d& rotation,
                                       const Placement& match) const {
  const double d = step.translation().norm();
  const double turn = std::abs(step.heading().radians());
  if (match.score < options_.lost_score) {
    const double sigma = 0.1 + 0.3 * d, sigma_rad = Angle::degrees(10).radians() + 0.5 * turn;
    return Eigen::Vector3d(sigma, sigma, sigma_rad).cwiseAbs2().cwiseInverse().asDiagonal();
  }
  const Eigen::Matrix3d by_match = match_information(match, rotation, 0.02 + 0.02 * d,
                                                     Angle::degrees(0.4).radians() + 0.02 * turn);
  return by_match + since_node_.inverse();
}

}  // namespace wayfare
