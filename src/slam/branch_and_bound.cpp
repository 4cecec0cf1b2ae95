#include <wayfare/match/branch_and_bound.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include "candidates.hpp"
#include "kernels/kernels.hpp"

namespace wayfare {

using detail::Best;
using detail::CandidateSpace;

/// Nodes of level l are squares of 4^(l+1) offsets bounded by level l of the pyramid.
struct BranchAndBoundMatcher::Search {
  BranchAndBoundMatcher& scratch;
  const MaxPyramid& map;
  const CandidateSpace& s;
  std::size_t padded;
  const kernels::Kernels& kernel = kernels::best_kernels();
  Best best = {};

  static int side(int level) { return 4 << (2 * level); }
  [[nodiscard]] const std::int32_t* u(int k) const { return at(scratch.u_, k); }
  [[nodiscard]] const std::int32_t* v(int k) const { return at(scratch.v_, k); }
  [[nodiscard]] const std::int32_t* at(const std::vector<std::int32_t>& a, int k) const {
    return a.data() + static_cast<std::size_t>(k + s.half_k) * padded;
  }

  [[nodiscard]] bool hopeless(const Node& n) const {
    return best.found &&
           (n.bound < best.objective ||
            (n.bound == best.objective && n.nearest > detail::distance_key(best.candidate)));
  }
  static bool before(const Node& a, const Node& b) {
    if (a.bound != b.bound) return a.bound > b.bound;
    if (a.nearest != b.nearest) return a.nearest < b.nearest;
    return a.corner < b.corner;
  }

  /// Bounds the sixteen nodes of `level` in the group at `corner` and appends those worth a look.
  void branch(const Candidate& corner, int level, std::vector<Node>& out) {
    const MaxPyramid::Level& l = map.level(level);
    const int n = s.points, k = corner.heading_step;
    kernel.bound_index(u(k), v(k), static_cast<int>(padded), corner.offset.x, corner.offset.y,
                       2 * level, l.width, l.height, l.columns, l.rows, scratch.index_.data());
    std::uint32_t sums[16];
    kernel.bound_scores(l.table.data(), scratch.index_.data(), n, sums);
    const int step = side(level);
    for (int i = 0; i < 16; ++i) {
      const std::int64_t sum = std::int64_t{16} * sums[i];
      if (sum < s.min_sum) continue;
      Node node{0, 0, {corner.offset + Cell{(i / 4) * step, (i % 4) * step}, k}, level};
      if (node.corner.offset.x > s.half_x || node.corner.offset.y > s.half_y) continue;
      node.bound = s.weight * static_cast<double>(sum) + s.log_prior_bound(node.corner, step);
      const std::int64_t x = nearest_to_zero(node.corner.offset.x, step);
      const std::int64_t y = nearest_to_zero(node.corner.offset.y, step);
      node.nearest = x * x + y * y + std::int64_t{k} * k;
      if (!hopeless(node)) out.push_back(node);
    }
  }
  static int nearest_to_zero(int corner, int step) {
    return corner > 0 ? corner : std::min(0, corner + step - 1);
  }

  /// Scores the 4×4 candidates of a node of level 0.
  void score(const Node& node) {
    const MatchGrid& grid = map.grid();
    const int k = node.corner.heading_step;
    kernel.index(u(k), v(k), static_cast<int>(padded), node.corner.offset.x, node.corner.offset.y,
                 grid.width(), grid.height(), grid.stride(), scratch.index_.data());
    std::uint32_t sums[4 * kernels::kBlock];
    kernel.block_scores(grid.data(), grid.stride(), scratch.index_.data(), s.points, 4, sums);
    for (int i = 0; i < 16; ++i) {
      const Candidate c{node.corner.offset + Cell{i % 4, i / 4}, k};
      if (c.offset.x > s.half_x || c.offset.y > s.half_y) continue;
      const std::uint32_t sum = sums[(i / 4) * kernels::kBlock + i % 4];
      if (sum >= s.min_sum) best.offer(s.objective(sum, c), sum, c);
    }
  }

  /// Depth first, the most promising child first.
  void descend(const Node& root) {
    auto& stack = scratch.stack_;
    stack.assign(1, root);
    while (!stack.empty()) {
      const Node node = stack.back();
      stack.pop_back();
      if (hopeless(node)) continue;
      if (node.level == 0) {
        score(node);
        continue;
      }
      const auto first = static_cast<std::ptrdiff_t>(stack.size());
      branch(node.corner, node.level - 1, stack);
      std::sort(stack.begin() + first, stack.end(),
                [](const Node& a, const Node& b) { return before(b, a); });
    }
  }

  void run(int level) {
    auto& roots = scratch.roots_;
    roots.clear();
    const int span = 4 * side(level);
    for (int k = -s.half_k; k <= s.half_k; ++k)
      for (int y = -s.half_y; y <= s.half_y; y += span)
        for (int x = -s.half_x; x <= s.half_x; x += span) branch({{x, y}, k}, level, roots);
    if (roots.empty()) return;
    // One dive gives a bound that rids the sort below of most nodes.
    descend(*std::min_element(roots.begin(), roots.end(), before));
    std::erase_if(roots, [&](const Node& n) { return hopeless(n); });
    std::sort(roots.begin(), roots.end(), before);
    for (const Node& root : roots) {
      if (best.found && root.bound < best.objective) break;
      descend(root);
    }
  }
};

Result<std::optional<MatchResult>> BranchAndBoundMatcher::match(const MaxPyramid& map,
                                                                const PointSet& points,
                                                                const SE2d& prior,
                                                                const SearchWindow& window,
                                                                const MatchOptions& options) {
  const auto space = detail::plan(map.grid(), points, prior, window, options, kMaxCandidates);
  if (!space) return space.error();
  const CandidateSpace& s = *space;
  const std::size_t padded = points.padded_x_m().size();
  const std::size_t headings = static_cast<std::size_t>(2 * s.half_k + 1);
  const int widest = 2 * std::max(s.half_x, s.half_y) + 1;
  const int level = widest <= 32 ? 0 : widest <= 1024 ? 1 : 2;
  const double groups = (widest / (4.0 * Search::side(level)) + 1);
  if (headings * padded > (std::size_t{1} << 26) ||
      groups * groups * static_cast<double>(headings) > 1 << 22)
    return Error{ErrorCode::invalid, "match: the search window is too large for these points"};
  u_.resize(headings * padded);
  v_.resize(headings * padded);
  index_.resize(padded);
  for (int k = -s.half_k; k <= s.half_k; ++k) {
    const std::size_t first = static_cast<std::size_t>(k + s.half_k) * padded;
    detail::place(s, map.grid(), points, k, u_.data() + first, v_.data() + first);
  }
  Search search{*this, map, s, padded};
  search.run(level);
  if (!search.best.found) return std::optional<MatchResult>();
  MatchResult result = detail::result_of(s, map.grid(), search.best);
  if (options.covariance) {
    MatchOptions local = options;
    local.prior_information.reset();
    local.min_score = 0;
    const double reach = 8 * s.resolution_m;
    const auto near = local_.match(map.grid(), points, result.T_map_points,
                                   {reach, reach, Angle::radians(8 * s.heading_step_rad)}, local);
    if (!near) return near.error();
    if (*near) result.covariance = (*near)->covariance;
  }
  return std::optional<MatchResult>(result);
}

}  // namespace wayfare
