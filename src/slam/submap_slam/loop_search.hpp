#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <list>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <wayfare/map/detail/precomputation_grids.hpp>
#include <wayfare/slam/detail/loops.hpp>
#include <wayfare/slam/detail/matched_map.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "slam/submap_slam/submap_graph.hpp"

namespace wayfare {

/// Searches finished submaps for the latest nodes, in the background with more than one thread. The
/// graph is not read after `begin` has returned; edges refer to it as it was then.
class LoopSearch {
 public:
  using MakeMap = decltype(detail::SubmapMaps::finished);
  LoopSearch(const SubmapSlamOptions& options, MakeMap make_map)
      : options_(options), make_map_(std::move(make_map)) {}

  /// Begins a search from the latest node, whose piece has this first node; false if there are no
  /// candidates.
  bool begin(const SubmapGraph& map, int first_of_piece);
  /// The result of the last search; waits for it.
  [[nodiscard]] const Loops& result();
  /// Result of a search that was running when the state was saved.
  void set_result(Loops found) { found_ = std::move(found); }

  /// Poses were dropped from the graph.
  void poses_dropped() { uncertainty_ = {}; }
  /// Drops the tables, which are made again when needed; not during a search.
  void drop_tables() { cache_.clear(); }
  /// Of the tables; waits for the running search.
  [[nodiscard]] std::size_t memory_bytes();

 private:
  /// Search tables of a finished submap; made from its points when needed, the map where the search
  /// has found something to refine: by the thread that matches this submap, as no other does.
  struct Tables {
    PrecomputationGrids field;
    std::optional<Error> fault;  ///< why the field could not be made
    std::unique_ptr<detail::MatchedMap> map;
    [[nodiscard]] std::size_t bytes() const;
  };
  using Cache = std::list<std::pair<std::int64_t, std::shared_ptr<Tables>>>;  // by submap
  struct Candidate {
    Submap submap;
    struct Scan {
      int pose;  // index in the graph
      SE2d T_submap_node;
      std::shared_ptr<const PackedPoints> points;
    };
    std::vector<Scan> scans;
    SE2d T_submap_node;
    Eigen::Matrix3d covariance;  // of T_submap_node
    std::shared_ptr<Tables> tables;
  };
  class Scans;
  struct Query {
    std::vector<Candidate> candidates;
    PointSet context, points;
    int pose = 0;  // of the latest node
  };

  [[nodiscard]] std::vector<std::pair<double, const Submap*>> near(const SubmapGraph& map) const;
  [[nodiscard]] std::vector<Candidate> candidates(const SubmapGraph& map);
  [[nodiscard]] PointSet context(const SubmapGraph& map, int first) const;
  [[nodiscard]] Loops search(Query& query);
  void find_tables(std::vector<Candidate>& candidates);
  [[nodiscard]] std::shared_ptr<Tables> make_tables(const Candidate& candidate) const;
  [[nodiscard]] LoopMatch match(const Query& query, const Candidate& candidate) const;

  SubmapSlamOptions options_;
  MakeMap make_map_;
  PathUncertaintyFinder uncertainty_;
  Loops found_;
  Cache cache_;                 // most recently used first
  std::future<Loops> running_;  // last: destroyed, and so waited for, before what it uses
};

}  // namespace wayfare
