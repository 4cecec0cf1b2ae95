#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <wayfare/core/contract.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare {

/// A time-stamped pose of any type.
template <class Pose>
struct StampedPoseOf {
  LogTime time;
  Transform<frame::Map, frame::Base, Pose> T_map_base;
};

namespace detail {

template <class Pose>
struct StampedType {
  using Type = StampedPoseOf<Pose>;
};
template <>
struct StampedType<SE2d> {
  using Type = StampedPose;
};

}  // namespace detail

/// StampedPose in the plane.
template <class Pose>
using Stamped = typename detail::StampedType<Pose>::Type;
template <class Pose>
using TrajectoryOf = std::vector<Stamped<Pose>>;

/// The trajectories of a particle set, which share the poses before a common ancestor: a tree of
/// poses with reference counts, which removes the branches of dropped particles, so that its size
/// grows with time and not with time × particles.
template <class Pose>
class AncestryTreeOf {
 public:
  using Node = std::int32_t;
  static constexpr Node kNone = -1;

  /// The first pose of a trajectory; the caller has one reference to the node.
  Node add_root(const Stamped<Pose>& pose) { return add_node(kNone, pose); }
  /// Extends a trajectory: the new node replaces the caller's reference to `end`.
  Node append(Node end, const Stamped<Pose>& pose) { return add_node(end, pose); }
  /// Adds a reference: another trajectory with the same poses up to `end`.
  void retain(Node end) { ++at(end).references; }
  /// Removes a reference, and all nodes that are then unreferenced.
  void release(Node end) {
    while (end != kNone && --at(end).references == 0) {
      free_.push_back(end);
      end = at(end).parent;
    }
  }

  [[nodiscard]] const Stamped<Pose>& pose(Node node) const {
    return nodes_[static_cast<std::size_t>(node)].pose;
  }
  /// From the root to `end`.
  [[nodiscard]] TrajectoryOf<Pose> trajectory(Node end) const {
    TrajectoryOf<Pose> poses;
    for (Node k = end; k != kNone; k = nodes_[static_cast<std::size_t>(k)].parent)
      poses.push_back(pose(k));
    std::reverse(poses.begin(), poses.end());
    return poses;
  }
  /// Number of poses stored.
  [[nodiscard]] std::size_t size() const { return nodes_.size() - free_.size(); }

 private:
  struct Entry {
    Stamped<Pose> pose;
    Node parent;
    std::int32_t references;  // by trajectories that end here and by child nodes
  };

  Entry& at(Node node) {
    WAYFARE_EXPECTS(node >= 0 && static_cast<std::size_t>(node) < nodes_.size(),
                    "no such node in the tree");
    return nodes_[static_cast<std::size_t>(node)];
  }
  Node add_node(Node parent, const Stamped<Pose>& pose) {
    const Entry entry{pose, parent, 1};
    if (free_.empty()) {
      nodes_.push_back(entry);
      return static_cast<Node>(nodes_.size() - 1);
    }
    const Node node = free_.back();
    free_.pop_back();
    nodes_[static_cast<std::size_t>(node)] = entry;
    return node;
  }

  std::vector<Entry> nodes_;
  std::vector<Node> free_;
};
using AncestryTree = AncestryTreeOf<SE2d>;

}  // namespace wayfare
