#pragma once

#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/match/scan_matcher.hpp>
#include <wayfare/slam/detail/check_match.hpp>
#include <wayfare/slam/detail/graph_slam/field_matching.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/detail/graph_slam/placement.hpp>
#include <wayfare/slam/graph_slam.hpp>

namespace wayfare::detail {

/// The spread of a match, by what its matcher says of it: the scene's constraint, or a covariance.
[[nodiscard]] Eigen::Matrix2d spread_of(const MatchResult& match);

/// Matching by a matcher of any kind, which makes its own maps. As an iterative matcher finds only
/// what is near its prior, poses far from it are searched in likelihood fields first.
template <MappingMatcher M>
class MatcherMatching {
 public:
  MatcherMatching(const GraphSlamOptions& options, const M& matcher)
      : options_(options), matcher_(matcher) {}

  void render(const NodeMap& nodes, bool /*is_close*/) {
    const int latest = nodes.latest();
    map_ = matcher_.make_map(
        nodes.chain(latest - options_.local_nodes + 1, latest, options_.local_radius_m));
  }
  /// Frees the memory of the local map; there is none until the next `render`.
  void release() { map_ = no_map(); }

  [[nodiscard]] Result<Placement> search(const PointSet& points, const SE2d& prior,
                                         const SearchWindow& window,
                                         const Eigen::Matrix3d& prior_information) {
    return matched(matcher_, map_, points, prior, window, errors_, prior_information);
  }

  /// Its iterations begin at the prior: the same as a search of this window.
  [[nodiscard]] Result<Placement> search_far(const PointSet& points, const SE2d& prior,
                                             const SearchWindow& window,
                                             const Eigen::Matrix3d& prior_information) {
    return search(points, prior, window, prior_information);
  }
  /// Not known.
  [[nodiscard]] static Result<bool> rival(const PointSet&, const SE2d&, const SearchWindow&,
                                          const Eigen::Matrix3d&, const Placement&) {
    return false;
  }

  [[nodiscard]] Result<Placement> search_around(const NodeMap& nodes, const PointSet& points,
                                                const SE2d& prior) {
    const Placement found = FieldMatching::search_nearby(nodes, points, prior, options_);
    if (!(found.score > 0.0)) return Placement{prior};
    const Map map = matcher_.make_map(
        nodes.around(found.T_map_points, kNear_m, kMostNear, nodes.part_of(nodes.latest())));
    return matched(matcher_, map, points, found.T_map_points, kAtFound, errors_);
  }

  /// The matcher's own result.
  [[nodiscard]] Placement refine(const PointSet&, const Placement& found) const { return found; }

  /// Nothing if the matcher's score there is not that of a tracked scan.
  [[nodiscard]] Result<std::optional<Placement>> confirm(std::span<const PlacedPoints> around,
                                                         const PointSet& points, const SE2d& found,
                                                         LocalMap&) const {
    M matcher = matcher_;  // candidates are matched in parallel
    MatcherErrors errors;
    const auto at = matched(matcher, matcher.make_map(around), points, found, kAtFound, errors);
    if (!at) return at.error();
    if (errors.count > 0) return Error{ErrorCode::numerical, errors.first};
    return at->score < options_.tracked_score ? std::nullopt : std::optional(*at);
  }

  /// Since the last call.
  [[nodiscard]] MatcherErrors take_errors() { return std::exchange(errors_, {}); }

 private:
  using Map = Result<typename M::Map>;
  static Map no_map() { return Error{ErrorCode::not_found, "no map yet"}; }

  static constexpr double kNear_m = 4.0;
  static constexpr std::size_t kMostNear = 80;
  /// Several cells of a likelihood field.
  static constexpr SearchWindow kAtFound{0.3, 0.3, Angle::degrees(10)};

  /// The prior with a score of 0 if there is no match, no map or an Error, which is added to
  /// `errors`; an Error if the match is not valid.
  static Result<Placement> matched(
      M& matcher, const Map& map, const PointSet& points, const SE2d& prior,
      const SearchWindow& window, MatcherErrors& errors,
      const std::optional<Eigen::Matrix3d>& prior_information = std::nullopt) {
    if (!map) {
      errors.add(map.error());
      return Placement{prior};
    }
    MatchOptions options;
    options.prior_information = prior_information;
    options.independent_points = kIndependentPoints;
    options.covariance = true;
    const auto match = matcher.match(*map, points, prior, window, options);
    if (!match) errors.add(match.error());
    if (!match || !*match) return Placement{prior};
    if (auto ok = check_match(**match); !ok) return ok.error();
    const SE2d& pose = (*match)->T_map_points;
    if (!within(pose, prior, window)) return Placement{prior};
    return Placement{pose, (*match)->score, spread_of(**match)};
  }

  /// Windows are rounded up to whole cells, by a fraction of the window or a few decimetres.
  static bool within(const SE2d& pose, const SE2d& prior, const SearchWindow& window) {
    constexpr double kCells_m = 0.3;
    const double moved = (pose.translation() - prior.translation()).norm();
    return moved <= 2.0 * (window.half_x_m + window.half_y_m) + kCells_m;
  }

  /// Errors of a scan's points are correlated.
  static constexpr double kIndependentPoints = 40.0;

  GraphSlamOptions options_;
  M matcher_;
  Map map_ = no_map();    // of the latest nodes
  MatcherErrors errors_;  // of tracking
};

}  // namespace wayfare::detail
