#include "slam/submap_slam/submap_graph.hpp"

#include <algorithm>
#include <utility>

namespace wayfare {

void SubmapGraph::add_node(const SE2d& T_local_node, std::shared_ptr<const PackedPoints> points,
                           const Eigen::Matrix3d& information) {
  SubmapNode added{0, T_local_node, 0.0, std::move(points)};
  SE2d T_map_node = T_local_node;
  if (!nodes.empty()) {
    const SubmapNode& before = nodes.back();
    const SE2d step = before.T_local_node.inverse() * T_local_node;
    added.travel_m = before.travel_m + step.translation().norm();
    T_map_node = pose(latest()) * step;
    graph.edges.push_back({before.pose, graph.size(), step, information, false});
  }
  added.pose = graph.add_pose(T_map_node);
  nodes.push_back(std::move(added));
}

void SubmapGraph::join_latest(const Submap& submap, const Eigen::Matrix3d& information) {
  const SubmapNode& n = nodes.back();
  graph.edges.push_back(
      {submap.pose, n.pose, submap.T_local_submap.inverse() * n.T_local_node, information, false});
}

void SubmapGraph::begin_submap() {
  const SubmapNode& n = nodes.back();
  const SE2d T_local_submap(n.T_local_node.translation(), SO2d());
  const int at = graph.add_pose(T_map_local() * T_local_submap);
  submaps.push_back({next_id_++, at, T_local_submap, latest(), latest(), false});
  constexpr double kExact = 1e6;  // to the millimetre
  join_latest(submaps.back(), kExact * Eigen::Matrix3d::Identity());
}

int SubmapGraph::forget_oldest() {
  const int kept = submaps[1].first;
  std::vector<char> gone(graph.poses.size(), 0);
  gone[static_cast<std::size_t>(submaps[0].pose)] = 1;
  for (int k = 0; k < kept; ++k) gone[static_cast<std::size_t>(node(k).pose)] = 1;
  submaps.erase(submaps.begin());
  nodes.erase(nodes.begin(), nodes.begin() + kept);
  for (Submap& s : submaps) {
    s.first -= kept;
    s.last -= kept;
  }
  drop_poses(gone);
  return kept;
}

void SubmapGraph::drop_poses(const std::vector<char>& gone) {
  std::vector<int> place(gone.size(), -1);
  PoseGraph2 rest;
  for (std::size_t i = 0; i < gone.size(); ++i)
    if (gone[i] == 0) place[i] = rest.add_pose(graph.poses[i]);
  const auto at = [&](int pose) { return place[static_cast<std::size_t>(pose)]; };
  for (PoseEdge<SE2d> e : graph.edges) {
    e.from = at(e.from);
    e.to = at(e.to);
    if (e.from >= 0 && e.to >= 0) rest.edges.push_back(e);
  }
  for (SubmapNode& n : nodes) n.pose = at(n.pose);
  for (Submap& s : submaps) s.pose = at(s.pose);
  graph = std::move(rest);
}

}  // namespace wayfare
