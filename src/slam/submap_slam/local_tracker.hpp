#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/match/correlative.hpp>
#include <wayfare/slam/detail/matched_map.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "slam/matched.hpp"
#include "slam/submap_slam/submap_graph.hpp"

namespace wayfare {

/// The unfinished submap that scans are matched to.
[[nodiscard]] inline const Submap& matched_submap(const SubmapGraph& map) {
  return *std::find_if(map.submaps.begin(), map.submaps.end(),
                       [](const Submap& s) { return !s.finished; });
}

/// Maps of the unfinished submaps; matches scans to the older of them.
class LocalTracker {
 public:
  using MakeMap = decltype(detail::SubmapMaps::growing);
  LocalTracker(const SubmapSlamOptions& options, MakeMap make_map)
      : options_(options), make_map_(std::move(make_map)) {}

  /// Pose of points in the local frame: by the match, and by the prediction along unconstrained
  /// directions.
  struct Placement {
    SE2d T_local_points;
    double score = 0.0;
    Eigen::Matrix3d covariance;
    double openness = 0.0;  ///< as LocalPlacement's
  };
  /// Nothing without agreement nearby; an Error for a match that is not valid. Errors of the
  /// matcher are added to `errors`.
  [[nodiscard]] Result<std::optional<Placement>> place(const SubmapGraph& map,
                                                       const PointSet& points,
                                                       const SE2d& T_local_expected,
                                                       const Motion& motion,
                                                       MatcherErrors& errors) const {
    constexpr std::size_t kFewestPoints = 10;
    if (points.size() < kFewestPoints) return std::optional<Placement>();
    MatchOptions options;
    options.min_score = options_.min_score;
    options.independent_points = options_.independent_points;
    options.prior_information = information_of(motion.sigma);
    options.covariance = true;
    const Eigen::Vector3d reach = options_.search_sigmas * motion.sigma;
    const double half_m = std::max(reach[0], reach[1]);
    auto best = match(map, points, T_local_expected, {half_m, half_m, Angle::radians(reach[2])},
                      options, errors);
    if (!best) return best.error();
    if (!*best || (*best)->score < options_.tracked_score) {
      constexpr double kMargin = 0.05;
      const auto other = search_wider(map, points, T_local_expected, motion, errors);
      if (!other) return other.error();
      if (*other && (*other)->score > (*best ? (*best)->score : 0.0) + kMargin) best = other;
    }
    if (!*best) return std::optional<Placement>();
    const OpenDirection open = open_direction(**best, points);
    return std::optional(Placement{open.settle((*best)->T_map_points, T_local_expected),
                                   (*best)->score, open.widen(covariance_of(**best)),
                                   open.openness()});
  }

  /// Updates the maps after a node was added, or a submap began or ended.
  Result<void> follow(const SubmapGraph& map) {
    std::erase_if(active_, [&](const Active& a) {
      return std::none_of(map.submaps.begin(), map.submaps.end(),
                          [&](const Submap& s) { return s.id == a.id && !s.finished; });
    });
    for (const Submap& s : map.submaps) {
      if (s.finished) continue;
      auto a = std::find_if(active_.begin(), active_.end(),
                            [&](const Active& have) { return have.id == s.id; });
      if (a == active_.end()) a = active_.insert(a, {s.id, 0, make_map_()});
      for (; a->nodes <= s.last - s.first; ++a->nodes) {
        const SubmapNode& n = map.node(s.first + a->nodes);
        if (auto ok =
                a->map->add(s.T_local_submap.inverse() * n.T_local_node, n.points->unpacked());
            !ok)
          return ok;
      }
    }
    return {};
  }

  [[nodiscard]] std::size_t memory_bytes() const {
    std::size_t bytes = 0;
    for (const Active& a : active_) bytes += a.map->memory_bytes();
    return bytes;
  }

 private:
  struct Active {
    std::int64_t id;
    int nodes;  // number inserted
    std::unique_ptr<detail::GrowingMap> map;
  };

  using Match = std::optional<MatchResult>;

  [[nodiscard]] Result<Match> match(const SubmapGraph& map, const PointSet& points,
                                    const SE2d& T_local_prior, const SearchWindow& window,
                                    const MatchOptions& options, MatcherErrors& errors) const {
    const SE2d& T_local_submap = matched_submap(map).T_local_submap;
    auto found = match_in(*active_.front().map, points, T_local_submap.inverse() * T_local_prior,
                          window, options, errors);
    if (!found || !*found) return found;
    (*found)->T_map_points = T_local_submap * (*found)->T_map_points;
    return found;
  }

  /// All poses in a window around the prediction, in a field with a wide basin of attraction.
  [[nodiscard]] Result<Match> search_wider(const SubmapGraph& map, const PointSet& points,
                                           const SE2d& T_local_expected, const Motion& motion,
                                           MatcherErrors& errors) const {
    constexpr double kOutlierProbability = 0.2, kPriorWeight = 0.25, kIndependentPoints = 8.0;
    const Submap& s = matched_submap(map);
    std::vector<PointSet> scans;
    std::vector<PlacedPoints> placed;
    scans.reserve(static_cast<std::size_t>(s.last - s.first + 1));
    for (int k = s.first; k <= s.last; ++k) {
      scans.push_back(map.node(k).points->unpacked());
      placed.push_back({&scans.back(), map.node(k).T_local_node});
    }
    const auto field = likelihood_field(
        placed, {options_.grid.finest.resolution_m, options_.loop_sigma_m, kOutlierProbability});
    if (!field) return Match();
    MatchOptions options;
    options.min_score = options_.lost_score;
    options.independent_points = kIndependentPoints;
    options.prior_information = kPriorWeight * information_of(motion.sigma);
    const double half_m = std::max({0.8, 2 * motion.sigma[0], 2 * motion.sigma[1]});
    const auto found = CorrelativeMatcher().match(*field, points, T_local_expected,
                                                  {half_m, half_m, Angle::degrees(50)}, options);
    if (!found || !*found) return Match();
    options = {};
    options.min_score = options_.min_score;
    options.covariance = true;
    return match(map, points, (*found)->T_map_points, {0.3, 0.3, Angle::degrees(5)}, options,
                 errors);
  }

  SubmapSlamOptions options_;
  MakeMap make_map_;
  std::vector<Active> active_;  // as the graph's unfinished submaps
};

}  // namespace wayfare
