#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>

#include <wayfare/match/correlative.hpp>

#include "map/kernels/kernels.hpp"
#include "match/search/candidates.hpp"

namespace wayfare {

/// For windows of a few groups per heading. The sum over a subset of the points gives an upper
/// bound with the others at their maximum, so a group is pruned as soon as that is too small.
/// Points spread over the scan come first, as they are most informative; once a good candidate is
/// known, those that fit it worst: they usually fit no other either, which makes the bounds tight
/// early.
struct BranchAndBoundMatcher::SmallSearch {
  /// Numbers of points used first and next, of groups evaluated first, of columns of a strip.
  static constexpr int kFirst = 48, kNext = 64, kProbes = 4, kStrip = kernels::kBlock;

  BranchAndBoundMatcher& scratch;
  const PrecomputationGrids& map;
  const detail::CandidateSpace& s;
  const PointSet& points;
  const kernels::Kernels& kernel = kernels::best_kernels();
  const kernels::BoundTable bounds = detail::bound_table(map.level(0));
  const kernels::CellTransform shift = detail::transform_of(s, map.grid(), 0);
  detail::Best best = {};
  std::uint32_t least = static_cast<std::uint32_t>(s.min_sum);  ///< smaller sums are pruned

  /// Orders the points so that the first kFirst are spread over the scan and most informative.
  void interleave() {
    const std::size_t n = points.size(), stride = (n + kFirst - 1) / kFirst;
    for (auto* axis : {&scratch.x_, &scratch.y_}) axis->assign(points.padded_x_m().size(), 0.0F);
    std::size_t out = 0;
    for (std::size_t first = 0; first < stride; ++first)
      for (std::size_t i = first; i < n; i += stride, ++out) {
        scratch.x_[out] = points.x_m()[i];
        scratch.y_[out] = points.y_m()[i];
      }
  }

  /// After the first points, those that fit the best candidate worst come next.
  void bring_outliers_forward() {
    if (!best.found || s.points <= kFirst + kNext) return;
    place(best.candidate);
    const LikelihoodField& grid = map.grid();
    const int rest = s.points - kFirst;
    const std::int32_t* at = index(best.candidate) + kFirst;
    auto& fit = scratch.fit_;  // (value, point)
    fit.clear();
    for (int i = 0; i < rest; ++i) fit.emplace_back(grid.data()[at[i]], kFirst + i);
    std::sort(fit.begin(), fit.end());
    for (auto* axis : {&scratch.x_, &scratch.y_}) {
      scratch.copy_ = *axis;
      auto out = axis->begin() + kFirst;
      for (const auto& [value, i] : fit) *out++ = scratch.copy_[static_cast<std::size_t>(i)];
    }
  }

  void add_points(Group& g, int count) {
    const int n = std::min(count, s.points - g.seen);
    kernels::CellTransform t = shift;
    t.c = g.c;
    t.s = g.s;
    t.du = g.corner.offset.x;
    t.dv = g.corner.offset.y;
    g.top = kernel.point_bounds(scratch.x_.data() + g.seen, scratch.y_.data() + g.seen, n, t,
                                bounds, g.sums);
    g.seen += n;
  }
  [[nodiscard]] bool prunable(const Group& g, std::uint32_t top) const {
    const std::uint32_t rest = 255 * static_cast<std::uint32_t>(s.points - g.seen);
    return 16 * (top + rest) < least;
  }

  void evaluate(Group& g) {
    while (!prunable(g, g.top)) {
      if (g.seen == s.points) return score_squares(g);
      add_points(g, kNext);
    }
  }

  /// Scores the rows of squares that are not pruned.
  void score_squares(Group& g) {
    place(g.corner);
    for (int j = 0; j < 4; ++j) {
      std::uint32_t top = 0;
      for (int i = 0; i < 4; ++i) top = std::max(top, g.sums[4 * i + j]);
      const int y = g.corner.offset.y + 4 * j;
      if (y <= s.half_y && !prunable(g, top))
        score({{g.corner.offset.x, y}, g.corner.heading_step});
    }
    g.top = 0;  // done
  }
  void place(const Candidate& c) {
    const kernels::CellTransform t = detail::transform_of(s, map.grid(), c.heading_step);
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
  /// Four rows of the placed points: first bounds over 2×2, then two rows at a time.
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
    least = std::max(least, static_cast<std::uint32_t>(detail::min_useful_sum(s, best)));
  }

  detail::Best run() {
    interleave();
    auto& groups = scratch.groups_;
    groups.clear();
    for (int k = -s.half_k; k <= s.half_k; ++k) {
      const kernels::CellTransform t = detail::transform_of(s, map.grid(), k);
      for (int y = -s.half_y; y <= s.half_y; y += 16)
        for (int x = -s.half_x; x <= s.half_x; x += 16) {
          groups.push_back({{{x, y}, k}, t.c, t.s, 0, 0, {}});
          add_points(groups.back(), kFirst);
        }
    }
    auto& order = scratch.order_;
    order.resize(groups.size());
    std::iota(order.begin(), order.end(), 0);
    const auto at = [&](std::int32_t i) -> Group& { return groups[static_cast<std::size_t>(i)]; };
    const auto probes = order.begin() + std::min<std::ptrdiff_t>(kProbes, std::ssize(order));
    std::partial_sort(order.begin(), probes, order.end(), [&](std::int32_t a, std::int32_t b) {
      return at(a).top != at(b).top ? at(a).top > at(b).top : a < b;
    });
    evaluate(at(order.front()));
    bring_outliers_forward();
    for (auto i = order.begin() + 1; i < probes; ++i) evaluate(at(*i));
    for (Group& g : groups) evaluate(g);  // in order, as neighbouring headings share cache lines
    return best;
  }
};

}  // namespace wayfare
