#include <wayfare/match/branch_and_bound.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <utility>

#include "candidates.hpp"
#include "kernels/kernels.hpp"

namespace wayfare {

using detail::Best;
using detail::CandidateSpace;

namespace {

/// A smaller sum cannot be better than the best: the log prior is never positive.
std::int64_t least_sum(const CandidateSpace& s, const Best& best) {
  if (best.objective <= 0) return 0;
  return static_cast<std::int64_t>(std::floor(best.objective / s.weight * (1 - 1e-12)));
}

constexpr int kFirst = 48;

/// The points in an order in which the first come from all over the scan, as those tell most.
void interleave(const PointSet& points, std::vector<float>& x, std::vector<float>& y) {
  const std::size_t n = points.size(), stride = (n + kFirst - 1) / kFirst;
  x.assign(points.padded_x_m().size(), 0.0F);
  y.assign(points.padded_x_m().size(), 0.0F);
  std::size_t out = 0;
  for (std::size_t first = 0; first < stride; ++first)
    for (std::size_t i = first; i < n; i += stride, ++out) {
      x[out] = points.x_m()[i];
      y[out] = points.y_m()[i];
    }
}

}  // namespace

/// Nodes of level l are squares of 4^(l+1) offsets bounded by level l of the pyramid.
struct BranchAndBoundMatcher::Search {
  BranchAndBoundMatcher& scratch;
  const MaxPyramid& map;
  const CandidateSpace& s;
  std::size_t padded;
  const kernels::Kernels& kernel = kernels::best_kernels();
  Best best = {};
  std::int64_t least = s.min_sum;  ///< a smaller sum cannot win

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

  /// Of the sixteen nodes of `level` in the group at `corner`; false as soon as the points seen
  /// leave none of them worth a look, however well the others fit.
  bool bound(const Candidate& corner, int level, std::uint32_t* sums) {
    constexpr int kMore = 64;
    const MaxPyramid::Level& l = map.level(level);
    const std::int32_t *x = u(corner.heading_step), *y = v(corner.heading_step);
    for (int seen = 0; seen < s.points; seen += kMore) {
      const int n = std::min(kMore, s.points - seen);
      kernel.bound_index(x + seen, y + seen, std::min(kMore, static_cast<int>(padded) - seen),
                         corner.offset.x, corner.offset.y, 2 * level, l.width, l.height, l.columns,
                         l.rows, scratch.index_.data());
      std::uint32_t some[16];
      kernel.bound_scores(l.table.data(), scratch.index_.data(), n, some);
      std::uint32_t top = 0;
      for (int i = 0; i < 16; ++i) top = std::max(top, sums[i] += some[i]);
      const std::int64_t rest = std::int64_t{255} * (s.points - seen - n);
      if (16 * (top + rest) < least) return false;
    }
    return true;
  }

  /// Bounds the sixteen nodes of `level` in the group at `corner` and appends those worth a look.
  void branch(const Candidate& corner, int level, std::vector<Node>& out) {
    const int k = corner.heading_step;
    std::uint32_t sums[16] = {};
    if (!bound(corner, level, sums)) return;
    const int step = side(level);
    for (int i = 0; i < 16; ++i) {
      const std::int64_t sum = std::int64_t{16} * sums[i];
      if (sum < least) continue;
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
    // First bounds over 2×2, then the rows in which one is worth it.
    std::uint32_t pairs[16], sums[2 * kernels::kBlock];
    kernel.pair_scores(map.pairs(), grid.stride(), scratch.index_.data(), s.points, pairs);
    for (int row = 0; row < 4; row += 2) {
      const std::uint32_t* pair = pairs + std::ptrdiff_t{4} * row;
      if (16 * std::int64_t{*std::max_element(pair, pair + 8)} < least) continue;
      kernel.block_scores(grid.data() + std::ptrdiff_t{row} * grid.stride(), grid.stride(),
                          scratch.index_.data(), s.points, 2, sums);
      for (int i = 0; i < 8; ++i) {
        const Candidate c{node.corner.offset + Cell{i % 4, row + i / 4}, k};
        if (c.offset.x > s.half_x || c.offset.y > s.half_y) continue;
        const std::uint32_t sum = sums[(i / 4) * kernels::kBlock + i % 4];
        if (sum >= s.min_sum) best.offer(s.objective(sum, c), sum, c);
      }
    }
    if (best.found) least = std::max(least, least_sum(s, best));
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

/// For windows of a few groups a heading. Any subset of the points bounds the rest at their best,
/// so a group is given up as soon as the points it has lost cannot be made good. Points from all
/// over the scan come first, as they tell most; once a good candidate is known, those that fit it
/// worst: they fit no other either, and the rest can then be taken to fit without much loss.
struct BranchAndBoundMatcher::SmallSearch {
  static constexpr int kMore = 64, kDives = 4, kStrip = kernels::kBlock;

  BranchAndBoundMatcher& scratch;
  const MaxPyramid& map;
  const CandidateSpace& s;
  const kernels::Kernels& kernel = kernels::best_kernels();
  const kernels::BoundTable bounds = table_of(map.level(0));
  const kernels::Turn shift = detail::turn_of(s, map.grid(), 0);
  Best best = {};
  std::uint32_t least = static_cast<std::uint32_t>(s.min_sum);  ///< a smaller sum cannot win

  static kernels::BoundTable table_of(const MaxPyramid::Level& l) {
    return {l.table.data(), 0, l.width, l.height, l.columns, l.rows};
  }

  /// Of the points after the first, those that fit the best candidate worst come next.
  void bring_outliers_forward() {
    if (!best.found || s.points <= kFirst + kMore) return;
    place(best.candidate);
    const MatchGrid& grid = map.grid();
    const int rest = s.points - kFirst;
    const std::int32_t* at = index(best.candidate) + kFirst;
    auto& fit = scratch.fit_;  // value, which
    fit.clear();
    for (int i = 0; i < rest; ++i) fit.emplace_back(grid.data()[at[i]], kFirst + i);
    std::sort(fit.begin(), fit.end());
    for (auto* axis : {&scratch.x_, &scratch.y_}) {
      scratch.copy_ = *axis;
      auto out = axis->begin() + kFirst;
      for (const auto& [value, i] : fit) *out++ = scratch.copy_[static_cast<std::size_t>(i)];
    }
  }

  void look(Group& g, int more) {
    const int n = std::min(more, s.points - g.seen);
    kernels::Turn turn = shift;
    turn.c = g.c;
    turn.s = g.s;
    turn.du = g.corner.offset.x;
    turn.dv = g.corner.offset.y;
    g.top = kernel.turned_bounds(scratch.x_.data() + g.seen, scratch.y_.data() + g.seen, n, turn,
                                 bounds, g.sums);
    g.seen += n;
  }
  [[nodiscard]] bool hopeless(const Group& g, std::uint32_t top) const {
    const std::uint32_t rest = 255 * static_cast<std::uint32_t>(s.points - g.seen);
    return 16 * (top + rest) < least;
  }

  void finish(Group& g) {
    while (!hopeless(g, g.top)) {
      if (g.seen == s.points) return open(g);
      look(g, kMore);
    }
  }

  /// Scores the rows of squares of which one is worth it.
  void open(Group& g) {
    place(g.corner);
    for (int j = 0; j < 4; ++j) {
      std::uint32_t top = 0;
      for (int i = 0; i < 4; ++i) top = std::max(top, g.sums[4 * i + j]);
      const int y = g.corner.offset.y + 4 * j;
      if (y <= s.half_y && !hopeless(g, top))
        score({{g.corner.offset.x, y}, g.corner.heading_step});
    }
    g.top = 0;  // done with
  }
  void place(const Candidate& c) {
    const kernels::Turn t = detail::turn_of(s, map.grid(), c.heading_step);
    kernel.place(scratch.x_.data(), scratch.y_.data(), static_cast<int>(scratch.x_.size()), t.c,
                 t.s, t.ox, t.oy, t.limit, scratch.u_.data(), scratch.v_.data());
  }
  const std::int32_t* index(const Candidate& c) {
    const MatchGrid& grid = map.grid();
    kernel.index(scratch.u_.data(), scratch.v_.data(), static_cast<int>(scratch.x_.size()),
                 c.offset.x, c.offset.y, grid.width(), grid.height(), grid.stride(),
                 scratch.index_.data());
    return scratch.index_.data();
  }
  /// Four rows from the placed points: first bounds over 2×2, then two rows at a time.
  void score(const Candidate& corner) {
    const std::int32_t* at = index(corner);
    std::uint32_t pairs[16];
    kernel.pair_scores(map.pairs(), map.grid().stride(), at, s.points, pairs);
    for (int r = 0; r < 4 && corner.offset.y + r <= s.half_y; r += 2) {
      const std::uint32_t* pair = pairs + std::ptrdiff_t{4} * r;
      if (16 * *std::max_element(pair, pair + 8) >= least) score_rows(corner, r, at);
    }
  }
  void score_rows(const Candidate& corner, int first, const std::int32_t* at) {
    const MatchGrid& grid = map.grid();
    std::uint32_t sums[2 * kStrip];
    const int rows = std::min(2, s.half_y - corner.offset.y - first + 1);
    const int columns = std::min(kStrip, s.half_x - corner.offset.x + 1);
    kernel.block_scores(grid.data() + std::ptrdiff_t{first} * grid.stride(), grid.stride(), at,
                        s.points, rows, sums);
    for (int r = 0; r < rows; ++r)
      for (int i = 0; i < columns; ++i)
        offer(sums[r * kStrip + i], {corner.offset + Cell{i, first + r}, corner.heading_step});
  }
  void offer(std::uint32_t sum, const Candidate& c) {
    if (sum < least) return;
    best.offer(s.objective(sum, c), sum, c);
    least = std::max(least, static_cast<std::uint32_t>(least_sum(s, best)));
  }

  void run() {
    auto& groups = scratch.groups_;
    groups.clear();
    for (int k = -s.half_k; k <= s.half_k; ++k) {
      const kernels::Turn turn = detail::turn_of(s, map.grid(), k);
      for (int y = -s.half_y; y <= s.half_y; y += 16)
        for (int x = -s.half_x; x <= s.half_x; x += 16) {
          groups.push_back({{{x, y}, k}, turn.c, turn.s, 0, 0, {}});
          look(groups.back(), kFirst);
        }
    }
    auto& order = scratch.order_;
    order.resize(groups.size());
    std::iota(order.begin(), order.end(), 0);
    const auto at = [&](std::int32_t i) -> Group& { return groups[static_cast<std::size_t>(i)]; };
    const auto dives = order.begin() + std::min<std::ptrdiff_t>(kDives, std::ssize(order));
    std::partial_sort(order.begin(), dives, order.end(), [&](std::int32_t a, std::int32_t b) {
      return at(a).top != at(b).top ? at(a).top > at(b).top : a < b;
    });
    finish(at(order.front()));
    bring_outliers_forward();
    for (auto i = order.begin() + 1; i < dives; ++i) finish(at(*i));
    for (Group& g : groups) finish(g);  // neighbouring headings read the same parts of the tables
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
  const bool small = std::max(s.half_x, s.half_y) <= 15;
  const std::size_t headings = small ? 1 : static_cast<std::size_t>(2 * s.half_k + 1);
  const int widest = 2 * std::max(s.half_x, s.half_y) + 1;
  const int level = widest <= 128 ? 1 : 2;
  const double groups = (widest / (4.0 * Search::side(level)) + 1);
  if (headings * padded > (std::size_t{1} << 26) ||
      groups * groups * static_cast<double>(headings) > 1 << 22)
    return Error{ErrorCode::invalid, "match: the search window is too large for these points"};
  u_.resize(headings * padded);
  v_.resize(headings * padded);
  index_.resize(padded);
  interleave(points, x_, y_);
  Best best;
  if (small) {
    SmallSearch search{*this, map, s};
    search.run();
    best = search.best;
  } else {
    for (int k = -s.half_k; k <= s.half_k; ++k) {
      const std::size_t first = static_cast<std::size_t>(k + s.half_k) * padded;
      const kernels::Turn t = detail::turn_of(s, map.grid(), k);
      kernels::best_kernels().place(x_.data(), y_.data(), static_cast<int>(padded), t.c, t.s, t.ox,
                                    t.oy, t.limit, u_.data() + first, v_.data() + first);
    }
    Search search{*this, map, s, padded};
    search.run(level);
    best = search.best;
  }
  if (!best.found) return std::optional<MatchResult>();
  MatchResult result = detail::result_of(s, map.grid(), best);
  if (options.covariance) {
    MatchOptions local = options;
    local.prior_information.reset();
    local.min_score = 0;
    const double reach = 8 * s.resolution_m;
    const auto near = local_.match(map.grid(), points, result.T_map_points,
                                   {reach, reach, Angle::radians(8 * s.heading_step_rad)}, local);
    if (!near) return near.error();
    if (*near) result.covariance = (*near)->covariance;
    result.constraint = detail::constraint_at(map.grid(), points, result.T_map_points);
  }
  return std::optional<MatchResult>(result);
}

}  // namespace wayfare
