#include "slam/submap_slam/loop_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <Eigen/LU>

#include <wayfare/core/parallel.hpp>
#include <wayfare/map/voxel_filter.hpp>
#include <wayfare/match/correlative.hpp>

#include "slam/matched.hpp"

namespace wayfare {
namespace {

/// From the latest node to the nearest of a submap's.
double distance_m(const SubmapGraph& map, const Submap& s) {
  double nearest = std::numeric_limits<double>::infinity();
  const Eigen::Vector2d here = map.pose(map.latest()).translation();
  for (int k = s.first; k <= s.last; ++k)
    nearest = std::min(nearest, (map.pose(k).translation() - here).norm());
  return nearest;
}

void append(PointSet& all, const SE2d& pose, const PointSet& points) {
  for (std::size_t i = 0; i < points.size(); ++i)
    all.push_back((pose * Eigen::Vector2d(points[i].cast<double>())).cast<float>());
}

}  // namespace

bool LoopSearch::begin(const SubmapGraph& map, int first_of_piece) {
  auto query = std::make_shared<Query>();
  query->candidates = candidates(map);
  if (query->candidates.empty()) return false;
  query->context = context(map, first_of_piece);
  query->points = map.nodes.back().points->unpacked();
  query->pose = map.nodes.back().pose;
  const auto policy =
      options_.threads > 1 ? std::launch::async | std::launch::deferred : std::launch::deferred;
  running_ = std::async(policy, [this, query] { return search(*query); });
  return true;
}

const Loops& LoopSearch::result() {
  if (running_.valid()) found_ = running_.get();
  return found_;
}

/// The finished submaps of an earlier visit so near to the latest node that, at the largest
/// uncertainty searched, they may share a view: no other is a candidate, at any uncertainty.
std::vector<std::pair<double, const Submap*>> LoopSearch::near(const SubmapGraph& map) const {
  std::vector<std::pair<double, const Submap*>> result;
  const double travel_m = map.nodes.back().travel_m;
  for (const Submap& s : map.submaps) {
    if (!s.finished || travel_m - map.node(s.last).travel_m < options_.loop_gap_travel_m) continue;
    const double away = distance_m(map, s);
    if (!(away - options_.loop_reach_m >= options_.loop_overlap_m)) result.emplace_back(away, &s);
  }
  return result;
}

/// The nearest submaps that may share a view with the latest node.
std::vector<LoopSearch::Candidate> LoopSearch::candidates(const SubmapGraph& map) {
  auto near = this->near(map);
  if (near.empty()) return {};
  std::vector<bool> wanted(map.graph.poses.size());
  for (const auto& [away, s] : near) wanted[static_cast<std::size_t>(s->pose)] = true;
  const PathUncertainty& known =
      uncertainty_from(map.nodes.back().pose, map.graph, loop_kernel(options_.loop_kernel_sigmas),
                       uncertainty_, [&, left = near.size()](int pose) mutable {
                         left -= wanted[static_cast<std::size_t>(pose)] ? 1 : 0;
                         wanted[static_cast<std::size_t>(pose)] = false;
                         return left == 0;
                       });
  std::erase_if(near, [&](const auto& candidate) {
    const auto& [away, s] = candidate;
    if (!known.reached(s->pose)) return true;
    const double reach = std::min(reach_m(known.covariance[static_cast<std::size_t>(s->pose)]),
                                  options_.loop_reach_m);
    return !(away - reach < options_.loop_overlap_m);
  });
  std::stable_sort(near.begin(), near.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  near.resize(std::min(near.size(), static_cast<std::size_t>(options_.loops_per_search)));
  std::vector<Candidate> result;
  for (const auto& [away, s] : near) {
    const SE2d T_submap_node = map.graph_pose(s->pose).inverse() * map.pose(map.latest());
    // The covariance found is of the submap relative to the node.
    const Eigen::Matrix3d move = T_submap_node.adjoint();
    Candidate c{*s, {}, T_submap_node, {}, nullptr};
    c.covariance = move.inverse() * known.covariance[static_cast<std::size_t>(s->pose)] *
                   move.inverse().transpose();
    for (int k = s->first; k <= s->last; ++k)
      c.scans.push_back({map.node(k).pose, s->T_local_submap.inverse() * map.node(k).T_local_node,
                         map.node(k).points});
    result.push_back(std::move(c));
  }
  return result;
}

/// The points of the latest nodes from `first` in the latest node's frame, one per 10 cm cell: a
/// larger and less ambiguous view than a single scan.
PointSet LoopSearch::context(const SubmapGraph& map, int first) const {
  constexpr double kCell_m = 0.1;
  const SE2d T_node_local = map.nodes.back().T_local_node.inverse();
  PointSet all;
  for (int k = map.latest(); k >= std::max(first, map.latest() - options_.loop_context_nodes); --k)
    append(all, T_node_local * map.node(k).T_local_node, map.node(k).points->unpacked());
  auto thinned = voxel_filter(all, kCell_m);
  return thinned ? *std::move(thinned) : all;
}

Loops LoopSearch::search(Query& query) {
  find_tables(query.candidates);
  std::vector<LoopMatch> matches(query.candidates.size(), std::optional<PoseEdge<SE2d>>());
  parallel_for(matches.size(), options_.threads - 1,
               [&](std::size_t i) { matches[i] = match(query, query.candidates[i]); });
  return Loops(matches);
}

/// Those in the cache first, so that none of them is dropped for another of the same search.
void LoopSearch::find_tables(std::vector<Candidate>& candidates) {
  for (Candidate& c : candidates) {
    const auto have = std::ranges::find(cache_, c.submap.id, &Cache::value_type::first);
    if (have == cache_.end()) continue;
    cache_.splice(cache_.begin(), cache_, have);
    c.tables = have->second;
  }
  const auto most = static_cast<std::size_t>(std::max(options_.tables_kept, 1));
  for (Candidate& c : candidates) {
    if (c.tables) continue;
    if (cache_.size() >= most) cache_.pop_back();
    c.tables = make_tables(c);
    cache_.emplace_front(c.submap.id, c.tables);
  }
}

/// The scans of a candidate's submap, in its frame.
class LoopSearch::Scans {
 public:
  explicit Scans(const Candidate& c) {
    points_.reserve(c.scans.size());
    for (const auto& [index, pose, packed] : c.scans) {
      points_.push_back(packed->unpacked());
      placed_.push_back({&points_.back(), pose});
    }
  }
  [[nodiscard]] std::span<const PlacedPoints> placed() const { return placed_; }

 private:
  std::vector<PointSet> points_;
  std::vector<PlacedPoints> placed_;
};

std::shared_ptr<LoopSearch::Tables> LoopSearch::make_tables(const Candidate& c) const {
  constexpr double kOutlierProbability = 0.2;
  const auto made = std::make_shared<Tables>();
  const Scans scans(c);
  auto field = likelihood_field(scans.placed(),
                                {options_.loop_cell_m, options_.loop_sigma_m, kOutlierProbability});
  if (field)
    made->field.build(*std::move(field));
  else if (std::ranges::any_of(scans.placed(), [](const auto& s) { return s.points->size() > 0; }))
    made->fault = field.error();
  made->field.release_workspace();
  return made;
}

/// Coarse search with the points of the latest nodes, refinement with those of the last one.
LoopMatch LoopSearch::match(const Query& query, const Candidate& c) const {
  std::optional<PoseEdge<SE2d>> edge;
  if (c.tables->fault) return *c.tables->fault;
  if (c.tables->field.grid().empty()) return edge;
  const SearchWindow window = loop_window(c.covariance, options_.loop_reach_m);
  MatchOptions options;
  options.min_score = window.half_x_m > 1.0 ? options_.wide_loop_score : options_.loop_score;
  BranchAndBoundMatcher far;
  const auto found = far.match(c.tables->field, query.context, c.T_submap_node, window, options);
  if (!found || !*found) return edge;
  options = {};
  options.independent_points = options_.independent_points;
  options.covariance = true;
  options.min_score = options_.min_score;
  MatcherErrors errors;
  if (!c.tables->map) c.tables->map = make_map_(Scans(c).placed());
  const auto near = match_in(*c.tables->map, query.points, (*found)->T_map_points,
                             {0.3, 0.3, Angle::degrees(6)}, options, errors);
  if (!near) return near.error();
  if (errors.count > 0) return Error{ErrorCode::numerical, errors.first};
  if (!*near) return edge;
  const Eigen::Vector3d floor(0.04, 0.04, Angle::degrees(0.6).radians());
  const OpenDirection open = open_direction(**near, query.points);
  const Eigen::Matrix3d covariance =
      open.widen(covariance_of(**near)) + Eigen::Matrix3d(floor.cwiseAbs2().asDiagonal());
  // Joined to the nearest scan of the submap, whose relative pose is the best known.
  const SE2d& T_submap_found = (*near)->T_map_points;
  const auto away = [&](const Candidate::Scan& s) {
    return (s.T_submap_node.translation() - T_submap_found.translation()).squaredNorm();
  };
  const auto nearest =
      std::min_element(c.scans.begin(), c.scans.end(),
                       [&](const auto& a, const auto& b) { return away(a) < away(b); });
  edge = {nearest->pose, query.pose, nearest->T_submap_node.inverse() * T_submap_found,
          covariance.inverse(), true};
  return edge;
}

std::size_t LoopSearch::Tables::bytes() const {
  const auto table = [](const PaddedTable& t) {
    return static_cast<std::size_t>(t.stride()) *
           static_cast<std::size_t>(t.height() + 2 * PaddedTable::kBorder);
  };
  std::size_t sum = 3 * table(field.grid());  // itself, and the maxima of pairs
  for (int l = 0; l < PrecomputationGrids::kLevels; ++l) sum += field.level(l).table.size();
  return map ? sum + map->memory_bytes() : sum;
}

std::size_t LoopSearch::memory_bytes() {
  (void)result();
  std::size_t sum = 0;
  for (const auto& entry : cache_) sum += entry.second->bytes();
  return sum;
}

}  // namespace wayfare
