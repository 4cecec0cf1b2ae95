#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <wayfare/core/contract.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare {

/// The ways of a set of particles, which share what they did before they were drawn from the same
/// one: a tree of poses that forgets the ways nobody leads any more, so that it grows with time and
/// not with time × particles.
class AncestryTree {
 public:
  using Node = std::int32_t;
  static constexpr Node kNone = -1;

  /// The first pose of a way; the caller holds it once.
  Node plant(const StampedPose& pose) { return make(kNone, pose); }
  /// A way goes on: the caller holds the new node in place of `end`.
  Node grow(Node end, const StampedPose& pose) { return make(end, pose); }
  /// Another way that was the same up to here.
  void hold(Node end) { ++at(end).held; }
  /// A way is given up.
  void release(Node end) {
    while (end != kNone && --at(end).held == 0) {
      free_.push_back(end);
      end = at(end).parent;
    }
  }

  [[nodiscard]] const StampedPose& pose(Node node) const {
    return nodes_[static_cast<std::size_t>(node)].pose;
  }
  /// From the first pose on.
  [[nodiscard]] Trajectory way(Node end) const {
    Trajectory poses;
    for (Node k = end; k != kNone; k = nodes_[static_cast<std::size_t>(k)].parent)
      poses.push_back(pose(k));
    std::reverse(poses.begin(), poses.end());
    return poses;
  }
  /// Poses kept.
  [[nodiscard]] std::size_t size() const { return nodes_.size() - free_.size(); }

 private:
  struct Entry {
    StampedPose pose;
    Node parent;
    std::int32_t held;  // by ways that end here and by nodes that go on from here
  };

  Entry& at(Node node) {
    WAYFARE_EXPECTS(node >= 0 && static_cast<std::size_t>(node) < nodes_.size(),
                    "no such node in the tree");
    return nodes_[static_cast<std::size_t>(node)];
  }
  Node make(Node parent, const StampedPose& pose) {
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

}  // namespace wayfare
