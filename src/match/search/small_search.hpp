#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>

#include <wayfare/match/branch_and_bound.hpp>

#include "map/kernels/kernels.hpp"
#include "match/search/candidates.hpp"
#include "match/search/search_parts.hpp"

namespace wayfare {

/// For windows of a few groups a heading. Any subset of the points bounds the rest at their best,
/// so a group is given up as soon as the points it has lost cannot be made good. Points from all
/// over the scan come first, as they tell most; once a good candidate is known, those that fit it
/// worst: they fit no other either, and the rest can then be taken to fit without much loss.
struct BranchAndBoundMatcher::SmallSearch {
  static constexpr int kMore = 64, kDives = 4, kStrip = kernels::kBlock;

  BranchAndBoundMatcher& scratch;
  const PrecomputationGrids& map;
  const detail::CandidateSpace& s;
  const kernels::Kernels& kernel = kernels::best_kernels();
  const kernels::BoundTable bounds = table_of(map.level(0));
  const kernels::CellTransform shift = detail::turn_of(s, map.grid(), 0);
  detail::Best best = {};
  std::uint32_t least = static_cast<std::uint32_t>(s.min_sum);  ///< a smaller sum cannot win

  static kernels::BoundTable table_of(const PrecomputationGrids::Level& l) {
    return {l.table.data(), 0, l.width, l.height, l.columns};
  }

  /// Of the points after the first, those that fit the best candidate worst come next.
  void bring_outliers_forward() {
    if (!best.found || s.points <= detail::kFirst + kMore) return;
    place(best.candidate);
    const LikelihoodField& grid = map.grid();
    const int rest = s.points - detail::kFirst;
    const std::int32_t* at = index(best.candidate) + detail::kFirst;
    auto& fit = scratch.fit_;  // value, which
    fit.clear();
    for (int i = 0; i < rest; ++i) fit.emplace_back(grid.data()[at[i]], detail::kFirst + i);
    std::sort(fit.begin(), fit.end());
    for (auto* axis : {&scratch.x_, &scratch.y_}) {
      scratch.copy_ = *axis;
      auto out = axis->begin() + detail::kFirst;
      for (const auto& [value, i] : fit) *out++ = scratch.copy_[static_cast<std::size_t>(i)];
    }
  }

  void look(Group& g, int more) {
    const int n = std::min(more, s.points - g.seen);
    kernels::CellTransform turn = shift;
    turn.c = g.c;
    turn.s = g.s;
    turn.du = g.corner.offset.x;
    turn.dv = g.corner.offset.y;
    g.top = kernel.point_bounds(scratch.x_.data() + g.seen, scratch.y_.data() + g.seen, n,
                                      turn, bounds, g.sums);
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
    const kernels::CellTransform t = detail::turn_of(s, map.grid(), c.heading_step);
    kernel.place(scratch.x_.data(), scratch.y_.data(), static_cast<int>(scratch.x_.size()), t.c,
                 t.s, t.ox, t.oy, t.limit, scratch.u_.data(), scratch.v_.data());
  }
  const std::int32_t* index(const Candidate& c) {
    const LikelihoodField& grid = map.grid();
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
    const LikelihoodField& grid = map.grid();
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
    least = std::max(least, static_cast<std::uint32_t>(detail::least_sum(s, best)));
  }

  void run() {
    auto& groups = scratch.groups_;
    groups.clear();
    for (int k = -s.half_k; k <= s.half_k; ++k) {
      const kernels::CellTransform turn = detail::turn_of(s, map.grid(), k);
      for (int y = -s.half_y; y <= s.half_y; y += 16)
        for (int x = -s.half_x; x <= s.half_x; x += 16) {
          groups.push_back({{{x, y}, k}, turn.c, turn.s, 0, 0, {}});
          look(groups.back(), detail::kFirst);
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

}  // namespace wayfare
