#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/map/detail/precomputation_grids.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/slam/detail/graph_slam/local_map.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/detail/graph_slam/wall_crossings.hpp>
#include <wayfare/slam/detail/loops.hpp>
#include <wayfare/slam/graph_slam.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare::detail {

/// Finds where a part of the map belongs in the others, without a prior pose: nodes and those
/// before them are matched to all nodes of the other part. Two parts are joined by matches of
/// different nodes that agree on their relative pose, or by one that agrees with the pose expected
/// at the end of a gap. A match must be the only one as good, and neither side may look through the
/// other's walls.
template <class Matching>
class PieceJoiner {
 public:
  PieceJoiner(const GraphSlamOptions& options, const Matching& matching)
      : options_(options), matching_(matching) {}

  /// The edges that join the part of node `at` to another, the first from the other part to `at`;
  /// empty if none is found.
  [[nodiscard]] std::vector<PoseEdge<SE2d>> search(NodeMap& nodes, int at) {
    if (nodes.parts().size() < 2) return {};
    const int part = nodes.part_of(at);
    const PointSet seen = nodes.context(at, options_.loop_context_nodes);
    for (const int other : nodes.parts()) {
      if (other == part || is_small(nodes, other) || !may_join(nodes, at, part, other)) continue;
      const auto edge = match(nodes, at, seen, other);
      if (!edge) continue;
      auto agreeing = agreeing_with(nodes, *edge);
      if (is_verified(agreeing) || is_expected(nodes, *edge)) return agreeing;
      nodes.possible_joins().push_back(*edge);
    }
    return {};
  }
  /// The same for the latest node: at intervals of `nodes_between_loops`, and where its piece is
  /// new.
  [[nodiscard]] std::vector<PoseEdge<SE2d>> search_latest(NodeMap& nodes) {
    const int at = nodes.latest();
    const bool is_new = at < nodes.first_of_piece(nodes.piece_of(at)) + options_.loop_context_nodes;
    if (!is_new && at % std::max(1, options_.nodes_between_loops) != 0) return {};
    return search(nodes, at);
  }
  /// The same for nodes of all parts, until edges are found.
  [[nodiscard]] std::vector<PoseEdge<SE2d>> search_all(NodeMap& nodes) {
    if (nodes.parts().size() < 2) return {};
    for (const int part : nodes.parts()) {
      const std::vector<int> all = nodes.nodes_of_part(part);
      const std::size_t step = all.size() < kFewestNodes ? 1 : 4;
      for (std::size_t i = step / 2; i < all.size(); i += step)
        if (auto edges = search(nodes, all[i]); !edges.empty()) return edges;
    }
    return {};
  }

  /// Nodes were removed or moved.
  void nodes_changed() { fields_.clear(); }

  void count(const NodeMap& nodes, PieceStatistics& statistics) {
    statistics.pieces = static_cast<std::size_t>(nodes.pieces());
    statistics.joins_refused += std::exchange(refused_, 0);
    statistics.pieces_apart = statistics.short_apart = 0;
    for (const int part : nodes.parts())
      if (part != 0) ++(is_small(nodes, part) ? statistics.short_apart : statistics.pieces_apart);
  }

  /// Whether a part of the map has too few nodes to be joined to.
  [[nodiscard]] static bool is_small(const NodeMap& nodes, int part) {
    return nodes.nodes_of_part(part).size() < kFewestNodes;
  }
  /// Small parts that are not joined go where their motion predicts them.
  static void place_small_parts(NodeMap& nodes) {
    for (const int part : nodes.parts()) {
      const Piece& piece = nodes.piece(part);
      if (!is_small(nodes, part) || !(piece.reach_m > 0.0)) continue;
      const SE2d first = nodes.pose(piece.before) * piece.T_before_first;
      nodes.move_part(part, first * nodes.pose(piece.first).inverse());
    }
  }

 private:
  /// All headings in a rectangle.
  struct Area {
    SE2d centre;
    SearchWindow window;
  };
  struct Field {
    std::size_t nodes = 0;  ///< when it was made
    PrecomputationGrids grids;
  };

  [[nodiscard]] const PrecomputationGrids& field(const NodeMap& nodes, int part) {
    const std::vector<int> all = nodes.nodes_of_part(part);
    Field& field = fields_[part];
    if (field.nodes == all.size()) return field.grids;
    std::vector<PlacedPoints> placed;
    for (const int k : all) placed.push_back({&nodes.points(k), nodes.pose(k)});
    field.nodes = all.size();
    auto made = likelihood_field(placed, {kCell_m, kSigma_m, kOutlierProbability});
    field.grids.build(made ? *std::move(made) : LikelihoodField());
    return field.grids;
  }

  /// Of the whole field, or a part of it.
  static Area all_of(const LikelihoodField& field) {
    const double half = 0.5 * field.resolution_m();
    const Eigen::Vector2d size(field.width() * half, field.height() * half);
    const Eigen::Vector2d corner(field.origin().x * 2 * half, field.origin().y * 2 * half);
    return {SE2d(Eigen::Vector2d(corner + size), SO2d()),
            {size.x(), size.y(), Angle::degrees(180)}};
  }

  [[nodiscard]] std::optional<MatchResult> search_in(const PrecomputationGrids& grids,
                                                     const PointSet& seen, const Area& area,
                                                     double min_score) {
    MatchOptions options;
    options.min_score = min_score;
    const auto found = far_.match(grids, seen, area.centre, area.window, options);
    return found ? *found : std::nullopt;
  }

  /// Whether a match of the node would say where it is: it is expected there, or the other part is
  /// the larger. In a small one a place seems to be the only one where others are not yet seen.
  [[nodiscard]] static bool may_join(const NodeMap& nodes, int at, int part, int other) {
    return expected_area(nodes, at, other).has_value() ||
           nodes.nodes_of_part(other).size() >= nodes.nodes_of_part(part).size();
  }

  /// Where a node should be, if that is known and in this part of the map.
  [[nodiscard]] static std::optional<Area> expected_area(const NodeMap& nodes, int at, int part) {
    const Piece& piece = nodes.piece(nodes.piece_of(at));
    if (!(piece.reach_m > 0.0) || nodes.part_of(piece.before) != part) return std::nullopt;
    const SE2d first = nodes.pose(piece.before) * piece.T_before_first;
    const SE2d moved = nodes.pose(piece.first).inverse() * nodes.pose(at);
    const double reach_m = piece.reach_m + moved.translation().norm();
    return Area{SE2d(first.translation(), SO2d()), {reach_m, reach_m, Angle::degrees(180)}};
  }

  [[nodiscard]] std::optional<PoseEdge<SE2d>> match(const NodeMap& nodes, int at,
                                                    const PointSet& seen, int part) {
    const PrecomputationGrids& grids = field(nodes, part);
    if (grids.grid().empty()) return std::nullopt;
    const Area all = all_of(grids.grid());
    const auto best = search_in(grids, seen, all, kCoarseScore);
    if (!best) return std::nullopt;
    if (auto edge = confirmed(nodes, at, seen, part, *best, all)) return edge;
    // Another place may be as good as the one expected.
    const auto near = expected_area(nodes, at, part);
    const auto there = near ? search_in(grids, seen, *near, best->score - kMargin) : std::nullopt;
    if (there)
      if (auto edge = confirmed(nodes, at, seen, part, *there, *near)) return edge;
    ++refused_;
    return std::nullopt;
  }

  /// The edge of a match found in an area, if it holds at full resolution, is the only one as good
  /// and nothing contradicts it.
  [[nodiscard]] std::optional<PoseEdge<SE2d>> confirmed(const NodeMap& nodes, int at,
                                                        const PointSet& seen, int part,
                                                        const MatchResult& coarse,
                                                        const Area& area) {
    const SE2d& rough = coarse.T_map_points;
    const std::vector<PlacedPoints> around = nodes.around(rough, kNear_m, kMostNear, part);
    LocalMap map;
    map.render(around, options_.cell_m, options_.search_sigma_m);
    const Placement fine = map.search(seen, rough, {0.25, 0.25, Angle::degrees(3)});
    if (fine.score < options_.wide_loop_score) return std::nullopt;
    const auto sharp = matching_.confirm(around, nodes.points(at), fine.T_map_points, map);
    if (!sharp || !*sharp) return std::nullopt;
    const SE2d& pose = (*sharp)->T_map_points;
    const PoseEdge<SE2d> edge = edge_to(nodes, at, **sharp, part);
    const bool is_here = is_expected(nodes, edge);
    const bool is_loose = map.refine(seen, pose).spread.trace() > kMostSpread;
    if (is_loose && !is_here) return std::nullopt;
    if (!(crossing(nodes, at, pose, around) < (is_here ? kMostCrossing : kFewCrossing)))
      return std::nullopt;
    if (has_rival(field(nodes, part), seen, pose, coarse.score, area)) return std::nullopt;
    return edge;
  }

  /// From the nearest node of the other part.
  [[nodiscard]] static PoseEdge<SE2d> edge_to(const NodeMap& nodes, int at, const Placement& sharp,
                                              int part) {
    const SE2d& pose = sharp.T_map_points;
    const int nearest = nodes.nearest(pose, part);
    const Eigen::Matrix3d information =
        match_information(sharp, pose.rotation(), 0.04, Angle::degrees(0.6).radians());
    return {nearest, at, nodes.pose(nearest).inverse() * pose, information, true};
  }

  /// The larger share of rays through walls: of the latest nodes through those of the other part's
  /// nodes nearby, and of these nodes' through theirs.
  [[nodiscard]] double crossing(const NodeMap& nodes, int at, const SE2d& pose,
                                std::span<const PlacedPoints> around) const {
    const SE2d move = pose * nodes.pose(at).inverse();
    std::vector<PlacedPoints> latest = nodes.chain(at - options_.loop_context_nodes, at);
    for (PlacedPoints& p : latest) p.T_map_points = move * p.T_map_points;
    const Eigen::Vector2d laser = options_.T_base_laser.raw().translation();
    return std::max(crossing_share(latest, map_of(around, laser), laser),
                    crossing_share(around, map_of(latest, laser), laser));
  }

  static OccupancyGrid map_of(std::span<const PlacedPoints> scans, const Eigen::Vector2d& laser) {
    OccupancyGrid grid;
    ScanRaster raster;
    for (const PlacedPoints& p : scans)
      (void)insert_points(grid, p.T_map_points, *p.points, {}, raster, laser);
    return grid;
  }

  /// Whether another place of the field, or of a window of it, is nearly as good.
  [[nodiscard]] bool has_rival(const PrecomputationGrids& grids, const PointSet& seen,
                               const SE2d& pose, double score, const Area& area) {
    constexpr double kTile_m = 4.0;
    constexpr int kSectors = 8;
    MatchOptions options;
    options.min_score = score - kMargin;
    const SearchWindow tile{kTile_m / 2, kTile_m / 2, Angle::degrees(180.0 / kSectors)};
    const Eigen::Vector2d half(area.window.half_x_m, area.window.half_y_m);
    const Eigen::Vector2d corner = area.centre.translation() - half;
    for (double x = kTile_m / 2; x < 2 * half.x() + kTile_m / 2; x += kTile_m)
      for (double y = kTile_m / 2; y < 2 * half.y() + kTile_m / 2; y += kTile_m)
        for (int h = 0; h < kSectors; ++h) {
          const SE2d at(Eigen::Vector2d(corner + Eigen::Vector2d(x, y)),
                        SO2d(Angle::degrees(h * 360.0 / kSectors)));
          const auto found = far_.match(grids, seen, at, tile, options);
          if (found && *found && !same_place((*found)->T_map_points, pose)) return true;
        }
    return false;
  }
  static bool same_place(const SE2d& a, const SE2d& b) {
    const SE2d d = a.inverse() * b;
    return d.translation().norm() < 1.5 && std::abs(d.heading().degrees()) < 25.0;
  }

  /// The match and those before of the same parts that agree with it on their relative pose; none
  /// of these if half as many do not.
  [[nodiscard]] std::vector<PoseEdge<SE2d>> agreeing_with(const NodeMap& nodes,
                                                          const PoseEdge<SE2d>& edge) const {
    std::vector<PoseEdge<SE2d>> agreeing = {edge};
    std::size_t others = 0;
    for (const PoseEdge<SE2d>& before : nodes.possible_joins()) {
      if (nodes.part_of(before.to) != nodes.part_of(edge.to) ||
          nodes.part_of(before.from) != nodes.part_of(edge.from))
        continue;
      if (agree(nodes, before, edge))
        agreeing.push_back(before);
      else
        ++others;
    }
    if (kMajority * others >= agreeing.size()) agreeing.resize(1);
    return agreeing;
  }
  /// Whether there are enough matches that share no nodes.
  [[nodiscard]] bool is_verified(const std::vector<PoseEdge<SE2d>>& agreeing) const {
    const auto [first, last] = std::minmax_element(
        agreeing.begin(), agreeing.end(), [](const auto& a, const auto& b) { return a.to < b.to; });
    return agreeing.size() >= kLeastMatches &&
           last->to - first->to > kContexts * options_.loop_context_nodes;
  }
  static bool agree(const NodeMap& nodes, const PoseEdge<SE2d>& a, const PoseEdge<SE2d>& b) {
    const SE2d by_a = placed(nodes, a) * nodes.pose(a.to).inverse() * nodes.pose(b.to);
    const SE2d d = by_a.inverse() * placed(nodes, b);
    const double travel_m = std::abs(nodes.travel_m(a.to) - nodes.travel_m(b.to));
    return d.translation().norm() < 0.3 + 0.03 * travel_m &&
           std::abs(d.heading().degrees()) < 4.0 + 0.3 * travel_m;
  }
  [[nodiscard]] static SE2d placed(const NodeMap& nodes, const PoseEdge<SE2d>& e) {
    return nodes.pose(e.from) * e.measurement;
  }

  /// Whether a match agrees with what was expected of its piece's first node.
  [[nodiscard]] bool is_expected(const NodeMap& nodes, const PoseEdge<SE2d>& e) const {
    const Piece& piece = nodes.piece(nodes.piece_of(e.to));
    if (!(piece.reach_m > 0.0) || nodes.part_of(piece.before) != nodes.part_of(e.from))
      return false;
    const SE2d at = placed(nodes, e) * nodes.pose(e.to).inverse() * nodes.pose(piece.first);
    const SE2d by_motion = nodes.pose(piece.before) * piece.T_before_first;
    return (at.translation() - by_motion.translation()).norm() < piece.reach_m;
  }

  static constexpr double kCell_m = 0.1, kSigma_m = 0.15, kOutlierProbability = 0.2;
  static constexpr double kCoarseScore = 0.65, kMargin = 0.04, kMostCrossing = 0.10,
                          kFewCrossing = 0.05, kMostSpread = 6.0;
  static constexpr std::size_t kFewestNodes = 4;  // of parts that are joined
  static constexpr double kNear_m = 6.0;
  static constexpr std::size_t kMostNear = 60, kLeastMatches = 3, kMajority = 2;
  static constexpr int kContexts = 2;

  GraphSlamOptions options_;
  Matching matching_;
  BranchAndBoundMatcher far_;
  std::map<int, Field> fields_;  // of parts
  std::size_t refused_ = 0;
};

}  // namespace wayfare::detail
