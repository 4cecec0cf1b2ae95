#pragma once

// The candidates of a search window, their scores and their order: shared by the exhaustive and the
// branch-and-bound matcher, so that their optima are identical.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <wayfare/map/detail/precomputation_grids.hpp>
#include <wayfare/match/scan_matcher.hpp>

#include "map/kernels/kernels.hpp"

namespace wayfare::detail {

/// Cosine and sine, in cells per metre.
struct Heading {
  float c, s;
};

struct CandidateSpace {
  int half_x, half_y, half_k;
  double heading_step_rad;
  double resolution_m;
  SE2d prior;
  int points;
  double weight;         ///< nats of the objective per unit of summed value
  std::int64_t min_sum;  ///< smallest summed value of a match
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of (x, y, θ) along the map's axes
  bool has_prior = false;
  std::vector<Heading> headings;  ///< of every heading step, from −half_k on

  [[nodiscard]] std::int64_t count() const {
    return (2LL * half_x + 1) * (2LL * half_y + 1) * (2LL * half_k + 1);
  }
  /// Among count(), ordered by (heading, y, x).
  [[nodiscard]] std::int64_t index(const Candidate& c) const {
    return ((c.heading_step + half_k) * (2LL * half_y + 1) + c.offset.y + half_y) *
               (2LL * half_x + 1) +
           c.offset.x + half_x;
  }
  [[nodiscard]] Eigen::Vector3d delta(const Candidate& c) const {
    return {c.offset.x * resolution_m, c.offset.y * resolution_m,
            c.heading_step * heading_step_rad};
  }
  [[nodiscard]] double log_prior(const Candidate& c) const {
    if (!has_prior) return 0.0;
    const Eigen::Vector3d d = delta(c);
    return -0.5 * d.dot(information * d);
  }
  [[nodiscard]] double objective(std::uint32_t sum, const Candidate& c) const {
    return weight * sum + log_prior(c);
  }
  /// Upper bound of the log prior in the square of `side` offsets from `corner`.
  [[nodiscard]] double log_prior_bound(const Candidate& corner, int side) const;
  [[nodiscard]] SE2d pose(const Candidate& c) const {
    return SE2d(Eigen::Vector2d(prior.translation() + delta(c).head<2>()),
                prior.rotation() * SO2d(Angle::radians(c.heading_step * heading_step_rad)));
  }
};

[[nodiscard]] inline std::int64_t distance_key(const Candidate& c) {
  const std::int64_t x = c.offset.x, y = c.offset.y, k = c.heading_step;
  return x * x + y * y + k * k;
}

struct Best {
  double objective = -1e300;
  std::uint32_t sum = 0;
  Candidate candidate;
  bool found = false;

  void offer(double value, std::uint32_t value_sum, const Candidate& c) {
    if (found && (value < objective || (value == objective && !nearer(c)))) return;
    *this = {value, value_sum, c, true};
  }

 private:
  [[nodiscard]] bool nearer(const Candidate& c) const {
    const std::int64_t a = distance_key(c), b = distance_key(candidate);
    if (a != b) return a < b;
    if (c.heading_step != candidate.heading_step) return c.heading_step < candidate.heading_step;
    if (c.offset.y != candidate.offset.y) return c.offset.y < candidate.offset.y;
    return c.offset.x < candidate.offset.x;
  }
};

/// Sums below cannot exceed the best objective, as the log prior is never positive.
[[nodiscard]] inline std::int64_t min_useful_sum(const CandidateSpace& s, const Best& best) {
  if (best.objective <= 0) return 0;
  return static_cast<std::int64_t>(std::floor(best.objective / s.weight * (1 - 1e-12)));
}

[[nodiscard]] inline kernels::BoundTable bound_table(const PrecomputationGrids::Level& l) {
  return {l.table.data(), 0, l.width, l.height, l.columns};
}

[[nodiscard]] Result<CandidateSpace> plan(const LikelihoodField& grid, const PointSet& points,
                                          const SE2d& prior, const SearchWindow& window,
                                          const MatchOptions& options, std::int64_t max_candidates);

/// Transformation of the points to cells of the table at heading step k.
[[nodiscard]] kernels::CellTransform transform_of(const CandidateSpace& space,
                                                  const LikelihoodField& grid, int k);

/// The points' cells in the table at heading step k; arrays of the padded points' size.
void place(const CandidateSpace& space, const LikelihoodField& grid, const PointSet& points, int k,
           std::int32_t* u, std::int32_t* v);

/// Calls `row(first offset, count, sums)` for every row of the 16×16 blocks of a rectangle of
/// offsets from the points' cells; `index` is scratch memory of the same size.
template <class Row>
void score_blocks(const LikelihoodField& grid, int points, const std::vector<std::int32_t>& u,
                  const std::vector<std::int32_t>& v, std::vector<std::int32_t>& index,
                  const CellBox& offsets, const Row& row) {
  constexpr int kBlock = kernels::kBlock;
  const auto& kernel = kernels::best_kernels();
  std::uint32_t sums[kBlock * kBlock];
  for (int y = offsets.min.y; y <= offsets.max.y; y += kBlock) {
    const int rows = std::min(kBlock, offsets.max.y - y + 1);
    for (int x = offsets.min.x; x <= offsets.max.x; x += kBlock) {
      kernel.index(u.data(), v.data(), static_cast<int>(u.size()), x, y, grid.width(),
                   grid.height(), grid.stride(), index.data());
      kernel.block_scores(grid.data(), grid.stride(), index.data(), points, rows, sums);
      const int columns = std::min(kBlock, offsets.max.x - x + 1);
      for (int r = 0; r < rows; ++r) row(Cell{x, y + r}, columns, sums + r * kBlock);
    }
  }
}

[[nodiscard]] MatchResult result_of(const CandidateSpace& space, const LikelihoodField& grid,
                                    const Best& best);

/// From the points that the match places near walls.
[[nodiscard]] SceneConstraint constraint_at(const LikelihoodField& grid, const PointSet& points,
                                            const SE2d& T_map_points);

}  // namespace wayfare::detail
