#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <list>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <wayfare/graph/path_uncertainty.hpp>
#include <wayfare/map/detail/precomputation_grids.hpp>
#include <wayfare/map/probability_grid.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "slam/submap_slam/submap_graph.hpp"

namespace wayfare {

/// What a search for loops gave: edges of the graph as it was when the search began.
struct FoundLoops {
  std::vector<PoseEdge<SE2d>> edges;
  std::size_t refused = 0;  ///< submaps searched, the place not found or not believed
};

/// Searches finished submaps for the place of the latest nodes, beside the caller's thread where
/// there is more than one. Nothing of the graph is read once `begin` has returned.
class LoopSearch {
 public:
  explicit LoopSearch(const SubmapSlamOptions& options) : options_(options) {}

  /// Begins a search from the latest node; false where there is nothing to be searched.
  bool begin(const SubmapGraph& map);
  /// The result of the search begun, waited for where it is not there yet.
  [[nodiscard]] const FoundLoops& result();
  /// What a search begun before the system was saved had found.
  void set_result(FoundLoops found) { found_ = std::move(found); }

  /// How far the optimiser is to believe a loop closure.
  [[nodiscard]] RobustKernel kernel() const {
    return {RobustKernelKind::cauchy, options_.loop_kernel_sigmas};
  }
  /// Poses were dropped from the graph.
  void graph_was_cut() { uncertainty_ = {}; }
  /// Of the tables; waits for the search under way.
  [[nodiscard]] std::size_t memory_bytes();

 private:
  /// What a finished submap is searched by; made from its points when it is asked for.
  struct Tables {
    PrecomputationGrids field;
    ProbabilityPyramid grid;
    [[nodiscard]] std::size_t bytes() const;
  };
  struct Candidate {
    Submap submap;
    struct Scan {
      int pose;  // its place in the graph
      SE2d T_submap_node;
      std::shared_ptr<const PackedPoints> points;
    };
    std::vector<Scan> scans;
    SE2d T_submap_node;
    Eigen::Matrix3d covariance;  // of that
    std::shared_ptr<const Tables> tables;
  };
  struct Query {
    std::vector<Candidate> candidates;
    PointSet context, points;
    int pose = 0;  // of the latest node
  };

  [[nodiscard]] std::vector<Candidate> candidates(const SubmapGraph& map);
  [[nodiscard]] PointSet context(const SubmapGraph& map) const;
  [[nodiscard]] FoundLoops search(Query& query);
  [[nodiscard]] std::shared_ptr<const Tables> tables(const Candidate& candidate);
  [[nodiscard]] std::shared_ptr<const Tables> make_tables(const Candidate& candidate) const;
  [[nodiscard]] std::optional<PoseEdge<SE2d>> match(const Query& query,
                                                    const Candidate& candidate) const;

  SubmapSlamOptions options_;
  PathUncertaintyFinder uncertainty_;
  FoundLoops found_;
  std::list<std::pair<std::int64_t, std::shared_ptr<const Tables>>> kept_;  // latest used first
  std::future<FoundLoops> running_;  // last: waited for before what it uses goes
};

}  // namespace wayfare
