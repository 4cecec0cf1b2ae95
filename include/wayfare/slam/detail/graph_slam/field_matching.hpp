#pragma once

#include <cmath>
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

  /// Makes the local maps of the latest nodes. Where predictions are close, cells of the blurred
  /// map may be wide; else the pose would drift along corridors.
  void render(const NodeMap& nodes, bool is_close) {
    const int latest = nodes.latest();
    const auto last = [&](int count) {
      return nodes.chain(latest - count + 1, latest, options_.local_radius_m);
    };
    is_coarse_ = is_close;
    search_map_.render(last(options_.local_nodes), (is_coarse_ ? 2.0 : 1.0) * options_.cell_m,
                       options_.search_sigma_m);
    sharp_map_.render(last(options_.sharp_nodes), options_.cell_m, options_.sharp_sigma_m);
  }
  /// Frees the memory of the local maps; they are empty until the next `render`.
  void release() {
    search_map_ = LocalMap();
    sharp_map_ = LocalMap();
  }

  [[nodiscard]] Result<Placement> search(const PointSet& points, const SE2d& prior,
                                         const SearchWindow& window,
                                         const Eigen::Matrix3d& prior_information) {
    return search_map_.search(points, prior, window, prior_information);
  }

  /// In a window of any size; the prior with a score of 0 if nothing agrees.
  [[nodiscard]] Result<Placement> search_far(const PointSet& points, const SE2d& prior,
                                             const SearchWindow& window,
                                             const Eigen::Matrix3d& prior_information) {
    return search_map_.search_far(points, prior, window, options_.lost_score, prior_information);
  }

  /// Whether a pose of the window with another heading agrees nearly as well as the `best`.
  [[nodiscard]] Result<bool> rival(const PointSet& points, const SE2d& prior,
                                   const SearchWindow& window,
                                   const Eigen::Matrix3d& prior_information,
                                   const Placement& best) {
    constexpr double kMargin = 0.1, kOther_deg = 25.0;
    const Angle half = Angle::degrees(22.5);
    const auto total = [&](const Placement& p) {
      const Eigen::Vector3d d = p.T_map_points.minus(prior);
      return p.score - 0.5 * d.dot(prior_information * d) / search_map_.score_weight();
    };
    for (Angle at = -window.half_heading + half; at <= window.half_heading; at = at + 2.0 * half) {
      const SE2d middle(prior.translation(), prior.rotation() * SO2d(at));
      const Placement found = search_map_.search_far(
          points, middle, {window.half_x_m, window.half_y_m, half}, best.score - kMargin);
      const SE2d apart = best.T_map_points.inverse() * found.T_map_points;
      if (found.score > 0.0 && std::abs(apart.heading().degrees()) > kOther_deg &&
          total(found) > total(best) - kMargin)
        return true;
    }
    return false;
  }

  /// At all headings in a map of all nodes nearby.
  [[nodiscard]] Result<Placement> search_around(const NodeMap& nodes, const PointSet& points,
                                                const SE2d& prior) const {
    return search_nearby(nodes, points, prior, options_);
  }

  /// Between the cells.
  [[nodiscard]] Placement refine(const PointSet& points, const Placement& found) const {
    return sharp_map_.refine(points, is_coarse_
                                         ? search_map_.between_cells(points, found.T_map_points)
                                         : found.T_map_points);
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
    around.render(nodes.around(prior, 4.0, 80, nodes.part_of(nodes.latest())), options.cell_m,
                  options.search_sigma_m);
    return around.search_far(points, prior, {1.0, 1.0, 180_deg}, 0.0,
                             information_of({0.5, 0.5, 1.0}));
  }

 private:
  GraphSlamOptions options_;
  LocalMap search_map_, sharp_map_;
  bool is_coarse_ = false;
};

}  // namespace wayfare::detail
