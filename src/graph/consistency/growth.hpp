#pragma once

// Acceptance of loops in the order of significance.

#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/loop_consistency.hpp>
#include <wayfare/graph/pose_graph.hpp>

#include "graph/consistency/cycles.hpp"

namespace wayfare::detail {

/// An Error names poses k and k + 1 that no trusted edge joins.
template <LieGroup G>
[[nodiscard]] Result<void> check_chain(const PoseGraph<G>& graph);

/// The loops of a valid graph with a chain of trusted edges, and which of them are accepted.
template <LieGroup G>
class LoopGrowth {
 public:
  /// Both must outlive it.
  LoopGrowth(const PoseGraph<G>& graph, const LoopConsistencyOptions& options);

  /// Accepts loops until no other is significant.
  void run();
  /// The same of the open loops by their relative covariances at the optimum of the accepted edges,
  /// which are smaller than those of paths; `path(loop)` is the LoopPath. False if none is.
  template <class Path>
  bool accept_by(const Path& path);

  /// The same of several open loops, none of which is significant alone: those that become so if
  /// one of them is accepted. False if there are none.
  bool accept_together();

  [[nodiscard]] double noise_scale() const { return scale_; }
  [[nodiscard]] int rounds() const { return rounds_; }
  /// Number of loops that agree, but not significantly, or close no cycle.
  [[nodiscard]] std::size_t open() const { return open_.size(); }
  /// Of an edge: trusted or accepted.
  [[nodiscard]] bool accepted(std::size_t edge) const { return state_[edge] == State::accepted; }
  /// It agrees, but not significantly.
  [[nodiscard]] bool undecided(std::size_t edge) const { return state_[edge] == State::open; }

 private:
  enum class State : char { open, accepted, refused };
  struct Agreement {
    double square = 0.0;   // d²
    double p_value = 1.0;  // probability that a false loop has the same d² or less
  };
  struct Candidate {
    int edge;
    double p_value;
  };

  void measure_spread();
  void estimate_scale();
  [[nodiscard]] Agreement compare(int edge, const LoopPath<G>& path) const;
  void reach(int hops);
  void compare_shortened(const std::vector<int>& accepted);
  double classify(int edge, const LoopPath<G>& path);
  [[nodiscard]] std::vector<Candidate> candidates(int hops) const;
  void accept(const std::vector<Candidate>& candidates);
  [[nodiscard]] std::vector<int> regions() const;
  [[nodiscard]] std::vector<Candidate> most_significant_by_region(
      const std::vector<int>& region) const;
  [[nodiscard]] double joint_log_p_value(const Candidate& first,
                                         const std::vector<int>& region) const;
  void drop_decided() {
    std::erase_if(open_, [&](int k) { return state_[static_cast<std::size_t>(k)] != State::open; });
  }
  bool accept_most_significant(std::vector<Candidate> candidates);

  const PoseGraph<G>& graph_;
  const LoopConsistencyOptions& options_;
  LoopPaths<G> paths_;
  std::vector<State> state_;      // of every edge
  std::vector<int> open_;         // loops
  std::vector<char> compared_;    // of every edge
  std::vector<double> p_values_;  // of every edge, as it was compared last
  int hops_ = 0;                  // loops with paths of so many edges at most are compared
  int unaccepted_ = 0;            // loops that were compared
  double spread_ = 0.0;           // variance of the distance along an axis between two poses, m²
  double gate_ = 0.0;
  double scale_ = 1.0;
  int rounds_ = 0;
};

template <LieGroup G>
template <class Path>
bool LoopGrowth<G>::accept_by(const Path& path) {
  std::vector<Candidate> candidates;
  for (const int k : open_) {
    const double by_path = p_values_[at(k)];
    const double p_value = classify(k, path(graph_.edges[at(k)]));
    p_values_[at(k)] = by_path;
    if (state_[at(k)] == State::open) candidates.push_back({k, p_value});
  }
  drop_decided();
  return accept_most_significant(std::move(candidates));
}

}  // namespace wayfare::detail
