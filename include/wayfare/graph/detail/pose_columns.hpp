#pragma once

#include <cstddef>
#include <vector>

#include <wayfare/graph/pose_graph.hpp>

namespace wayfare {

/// The block column of each free pose of a graph.
class PoseColumns {
 public:
  template <LieGroup G>
  void number(const PoseGraph<G>& graph) {
    columns_.assign(graph.poses.size(), 0);
    if (graph.fixed.empty() && !columns_.empty()) columns_[0] = -1;
    for (const int pose : graph.fixed) columns_[static_cast<std::size_t>(pose)] = -1;
    free_.clear();
    for (int pose = 0; pose < graph.size(); ++pose) {
      int& column = columns_[static_cast<std::size_t>(pose)];
      if (column < 0) continue;
      column = static_cast<int>(free_.size());
      free_.push_back(pose);
    }
  }

  [[nodiscard]] std::size_t poses() const { return columns_.size(); }
  /// The free poses in the order of their columns.
  [[nodiscard]] const std::vector<int>& free() const { return free_; }
  /// The column of a pose, −1 if it is fixed.
  [[nodiscard]] int of(int pose) const { return columns_[static_cast<std::size_t>(pose)]; }

 private:
  std::vector<int> columns_, free_;
};

}  // namespace wayfare
