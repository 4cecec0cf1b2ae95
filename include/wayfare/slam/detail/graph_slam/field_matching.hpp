#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/slam/detail/graph_slam/local_map.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/graph_slam.hpp>

namespace wayfare::detail {

/// Matching to likelihood fields: correlative search in a blurred one, refinement in a sharp one.
/// Never an Error.
class FieldMatching {
 public:
  explicit FieldMatching(const GraphSlamOptions& options) : options_(options) {}

  /// Makes the local maps of the latest nodes.
  void render(const NodeMap& nodes) {
    const int latest = nodes.latest();
    const auto last = [&](int count) {
      return nodes.chain(latest - count + 1, latest, options_.local_radius_m);
    };
    search_map_.render(last(options_.local_nodes), options_.cell_m, options_.search_sigma_m);
    sharp_map_.render(last(options_.sharp_nodes), options_.cell_m, options_.sharp_sigma_m);
  }

  [[nodiscard]] Result<Placement> search(const PointSet& points, const SE2d& prior,
                                         const SearchWindow& window,
                                         const Eigen::Matrix3d& prior_information) {
    return search_map_.search(points, prior, window, prior_information);
  }

  /// At all headings in a map of all nodes nearby.
  [[nodiscard]] Result<Placement> search_around(const NodeMap& nodes, const PointSet& points,
                                                const SE2d& prior) const {
    return search_nearby(nodes, points, prior, options_);
  }

  /// Between the cells.
  [[nodiscard]] Placement refine(const PointSet& points, const Placement& found) const {
    return sharp_map_.refine(points, found.T_map_points);
  }

  /// The pose of the latest scan at a loop found in a field of the scans `around`; always agrees.
  /// `map` is overwritten.
  [[nodiscard]] Result<std::optional<Placement>> confirm(std::span<const PlacedPoints> around,
                                                         const PointSet& points, const SE2d& found,
                                                         LocalMap& map) const {
    map.render(around, options_.cell_m, options_.sharp_sigma_m);
    return std::optional(map.refine(points, found));
  }

  [[nodiscard]] static MatcherErrors take_errors() { return {}; }

  /// In a field of all nodes nearby, at all headings.
  [[nodiscard]] static Placement search_nearby(const NodeMap& nodes, const PointSet& points,
                                               const SE2d& prior, const GraphSlamOptions& options) {
    LocalMap around;
    around.render(nodes.around(prior, 4.0, 80), options.cell_m, options.search_sigma_m);
    return around.search(points, prior, {1.0, 1.0, 180_deg}, information_of({0.5, 0.5, 1.0}));
  }

 private:
  GraphSlamOptions options_;
  LocalMap search_map_, sharp_map_;
};

}  // namespace wayfare::detail
