#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <iterator>
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

  /// Up to four nodes beside each other along x, a bit each.
  struct Row {
    Candidate corner;  ///< of the first, wanted or not
    unsigned members;
  };

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

  /// Of the nodes of `level` in the groups `wanted` (a bit each) of the row from `corner` on. Those
  /// left: a group is given up once the points seen leave no node worth a look, if all others fit.
  unsigned bound(const Candidate& corner, int level, unsigned wanted, std::uint32_t* sums) {
    constexpr int kMore = 64;
    const MaxPyramid::Level& l = map.level(level);
    const std::int32_t *x = u(corner.heading_step), *y = v(corner.heading_step);
    for (int seen = 0; seen < s.points && wanted != 0; seen += kMore) {
      const int n = std::min(kMore, s.points - seen);
      std::int32_t* index = scratch.index_.data();
      kernel.bound_index(x + seen, y + seen, std::min(kMore, static_cast<int>(padded) - seen),
                         corner.offset.x, corner.offset.y, 2 * level, l.width, l.height, l.columns,
                         index);
      std::uint32_t top[4] = {};
      if (const auto only = std::countr_zero(wanted); std::has_single_bit(wanted))
        top[only] = kernel.bound_scores(l.table.data() + std::ptrdiff_t{16} * only, index, n,
                                        sums + std::ptrdiff_t{16} * only);
      else
        kernel.row_bound_scores(l.table.data(), index, n, sums, top);
      const std::int64_t rest = std::int64_t{255} * (s.points - seen - n);
      for (int g = 0; g < 4; ++g)
        if (16 * (top[g] + rest) < least) wanted &= ~(1U << g);
    }
    return wanted;
  }

  /// Bounds the nodes of `level` in groups of the row and appends those worth a look.
  void branch(const Row& row, int level, std::vector<Node>& out) {
    const Candidate& corner = row.corner;
    const int k = corner.heading_step, step = side(level);
    std::uint32_t sums[64] = {};
    const unsigned left = bound(corner, level, row.members, sums);
    if (left == 0) return;
    for (int i = 0; i < 64; ++i) {
      const std::int64_t sum = std::int64_t{16} * sums[i];
      if (sum < least || (left >> (i / 16) & 1) == 0) continue;
      Node node{0, 0, {corner.offset + Cell{(i / 4) * step, (i % 4) * step}, k}, level};
      if (node.corner.offset.x > s.half_x || node.corner.offset.y > s.half_y) continue;
      node.bound = s.weight * static_cast<double>(sum) + s.log_prior_bound(node.corner, step);
      const std::int64_t x = detail::nearest_to_zero(node.corner.offset.x, step);
      const std::int64_t y = detail::nearest_to_zero(node.corner.offset.y, step);
      node.nearest = x * x + y * y + std::int64_t{k} * k;
      if (!hopeless(node)) out.push_back(node);
    }
  }

  /// Scores the candidates of a row of nodes of level 0.
  void score(const Row& row) {
    const MatchGrid& grid = map.grid();
    const Cell& corner = row.corner.offset;
    const int k = row.corner.heading_step;
    kernel.index(u(k), v(k), static_cast<int>(padded), corner.x, corner.y, grid.width(),
                 grid.height(), grid.stride(), scratch.index_.data());
    // First bounds over 2×2, then the rows in which one is worth it.
    std::uint32_t pairs[16], sums[2 * kernels::kBlock];
    kernel.pair_scores(map.pairs(), grid.stride(), scratch.index_.data(), s.points, pairs);
    for (int r = 0; r < 4; r += 2) {
      std::int64_t top = 0;
      for (int i = 0; i < 8; ++i)
        if ((row.members >> (i / 2) & 1) != 0) top = std::max<std::int64_t>(top, pairs[4 * r + i]);
      if (16 * top < least) continue;
      kernel.block_scores(grid.data() + std::ptrdiff_t{r} * grid.stride(), grid.stride(),
                          scratch.index_.data(), s.points, 2, sums);
      for (int i = 0; i < 2 * kernels::kBlock; ++i) {
        const Candidate c{corner + Cell{i % kernels::kBlock, r + i / kernels::kBlock}, k};
        if (sums[i] < least || c.offset.x > s.half_x || c.offset.y > s.half_y) continue;
        best.offer(s.objective(sums[i], c), sums[i], c);
      }
      if (best.found) least = std::max(least, detail::least_sum(s, best));
    }
  }

  /// Where the row begins that the node is of.
  [[nodiscard]] Candidate row_of(const Node& n) const {
    const int x = n.corner.offset.x, within = (x + s.half_x) & (4 * side(n.level) - 1);
    return {{x - within, n.corner.offset.y}, n.corner.heading_step};
  }

  /// Off the stack, the last node and those of its level beside it: what bounds or scores them lies
  /// side by side in memory.
  Row take_row() {
    auto& stack = scratch.stack_;
    const int level = stack.back().level;
    Row row{row_of(stack.back()), 0};
    auto first = stack.end();
    while (first != stack.begin() && std::prev(first)->level == level) --first;
    const auto beside = [&](const Node& n) {
      if (row_of(n) != row.corner) return false;
      const int place = (n.corner.offset.x - row.corner.offset.x) / side(level);
      if (!hopeless(n)) row.members |= 1U << place;
      return true;
    };
    stack.erase(std::remove_if(first, stack.end(), beside), stack.end());
    return row;
  }

  /// Depth first, the most promising child first.
  void descend(const Node& root) {
    auto& stack = scratch.stack_;
    stack.assign(1, root);
    while (!stack.empty()) {
      const int level = stack.back().level;
      const Row row = take_row();
      if (row.members == 0) continue;
      const auto first = static_cast<std::ptrdiff_t>(stack.size());
      level == 0 ? score(row) : branch(row, level - 1, stack);
      std::sort(stack.rbegin(), std::reverse_iterator(stack.begin() + first), before);
    }
  }

  void run(int level) {
    auto& roots = scratch.roots_;
    roots.clear();
    const int span = 4 * side(level);
    for (int k = -s.half_k; k <= s.half_k; ++k)
      for (int y = -s.half_y; y <= s.half_y; y += span)
        for (int x = -s.half_x; x <= s.half_x; x += 4 * span)
          branch({{{x, y}, k}, (1U << std::min(4, (s.half_x - x) / span + 1)) - 1}, level, roots);
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
