#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <wayfare/match/branch_and_bound.hpp>

#include "candidates.hpp"
#include "kernels/kernels.hpp"
#include "search_parts.hpp"

namespace wayfare {

/// Nodes of level l are squares of 4^(l+1) offsets bounded by level l of the pyramid.
struct BranchAndBoundMatcher::Search {
  BranchAndBoundMatcher& scratch;
  const MaxPyramid& map;
  const detail::CandidateSpace& s;
  std::size_t padded;
  const kernels::Kernels& kernel = kernels::best_kernels();
  detail::Best best = {};
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
    if (best.found) least = std::max(least, detail::least_sum(s, best));
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

}  // namespace wayfare
