#include <wayfare/match/correlative.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "match/search/small_search.hpp"

namespace wayfare {

/// Nodes of level l are squares of 4^(l+1) offsets bounded by level l of the precomputation grids;
/// four adjacent nodes along x are a row. On each level the most promising rows are refined in
/// batches of growing size, in memory order: neighbours and neighbouring headings read the same
/// parts of the tables.
struct BranchAndBoundMatcher::Search {
  static constexpr std::size_t kGrowth = 4, kMaxRows = 4096;
  static constexpr std::size_t kNotBuilt = static_cast<std::size_t>(-1);
  /// Most merged points stored; beyond, all are cleared and rebuilt on demand.
  static constexpr std::size_t kMaxMerged = std::size_t{1} << 24;

  BranchAndBoundMatcher& scratch;
  const PrecomputationGrids& map;
  const detail::CandidateSpace& s;
  const PointSet& all;
  const kernels::Kernels& kernel = kernels::best_kernels();
  detail::Best best = {};
  std::int64_t least = s.min_sum;  ///< smaller sums are pruned

  static int side(int level) { return 4 << (2 * level); }
  static auto at(int level) { return static_cast<std::size_t>(level); }

  void clear(detail::MergedPoints& m) const {
    m.parts = (s.points + kernels::kMergedPart - 1) / kernels::kMergedPart;
    m.first.assign(s.headings.size(), kNotBuilt);
    m.ends.resize(s.headings.size() * at(m.parts));
    m.used = 0;
  }
  /// The points at a heading step in units of the level from the window's corner. Groups begin at
  /// whole units from there, so that they share the entries.
  kernels::Merged points(int level, int heading_step) {
    detail::MergedPoints& m = scratch.merged_[at(level)];
    const std::size_t heading = at(heading_step + s.half_k), count = at(s.points);
    if (m.first[heading] == kNotBuilt) {
      if (m.used + count > kMaxMerged) clear(m);
      const std::size_t needed = m.used + count + 16;  // as many may be read past the end
      if (needed > m.x.size()) {
        for (auto* axis : {&m.x, &m.y}) axis->resize(needed + needed / 2);
        m.weight.resize(m.x.size());
      }
      detail::place(s, map.grid(), all, heading_step, scratch.u_.data(), scratch.v_.data());
      m.first[heading] = m.used;
      m.used += at(kernel.merge(scratch.u_.data(), scratch.v_.data(), s.points,
                                {-s.half_x, -s.half_y, 2 * level}, m.x.data() + m.used,
                                m.y.data() + m.used, m.weight.data() + m.used,
                                m.ends.data() + heading * at(m.parts)));
    }
    const std::size_t first = m.first[heading];
    return {m.x.data() + first, m.y.data() + first, m.weight.data() + first,
            m.ends.data() + heading * at(m.parts)};
  }
  /// Of the `count` integers from `first`.
  static int nearest_to_zero(int first, int count) {
    return first > 0 ? first : std::min(0, first + count - 1);
  }
  [[nodiscard]] std::int64_t nearest(const Row& row) const {
    std::int64_t key = INT64_MAX;
    for (int i = 0; i < 4; ++i) {
      if ((row.members >> i & 1) == 0) continue;
      const int step = side(row.level);
      const std::int64_t x = nearest_to_zero(row.corner.offset.x + i * step, step);
      key = std::min(key, x * x);
    }
    const std::int64_t y = nearest_to_zero(row.corner.offset.y, side(row.level));
    const std::int64_t k = row.corner.heading_step;
    return key + y * y + k * k;
  }
  [[nodiscard]] bool prunable(const Row& row) const {
    return best.found &&
           (row.bound < best.objective ||
            (row.bound == best.objective && nearest(row) > detail::distance_key(best.candidate)));
  }

  /// Bounds the nodes of `level` in the groups `wanted` (bit mask) of the row from `corner`;
  /// returns the groups left. A group is pruned once its sums are too small even if all other
  /// points fit.
  unsigned bound(const Candidate& corner, int level, unsigned wanted, std::uint32_t* sums) {
    const PrecomputationGrids::Level& l = map.level(level);
    const kernels::Merged merged = points(level, corner.heading_step);
    const int dx = (corner.offset.x + s.half_x) >> (2 * level);
    const int dy = (corner.offset.y + s.half_y) >> (2 * level);
    kernels::BoundTable table = detail::bound_table(l);
    for (int part = 0, rest = s.points; rest > 0 && wanted != 0; ++part) {
      rest = std::max(0, rest - kernels::kMergedPart);
      // Adjacent groups share look-ups.
      const int low = std::countr_zero(wanted);
      const int span = static_cast<int>(std::bit_width(wanted)) - low;
      const int groups = span > 2 ? 4 : span, first = span > 2 ? 0 : low;
      table.table = l.table.data() + std::ptrdiff_t{16} * first;
      kernel.merged_bounds(merged, part, table, dx, dy, groups, sums + std::ptrdiff_t{16} * first);
      for (int g = 0; g < 4 && rest > 0; ++g) {
        const std::uint32_t* sum = sums + std::ptrdiff_t{16} * g;
        if (16 * (*std::max_element(sum, sum + 16) + std::int64_t{255} * rest) < least)
          wanted &= ~(1U << g);
      }
    }
    return wanted;
  }

  /// Bounds the nodes of `level` in groups of the row and appends the rows that are not pruned.
  void branch(const Candidate& corner, unsigned groups, int level) {
    std::uint32_t sums[64] = {};
    const unsigned left = bound(corner, level, groups, sums);
    const int step = side(level), rows = std::min(4, (s.half_y - corner.offset.y) / step + 1);
    for (int g = 0; g < 4; ++g) {
      const Cell first = corner.offset + Cell{4 * g * step, 0};
      if ((left >> g & 1) == 0 || first.x > s.half_x) continue;
      for (int j = 0; j < rows; ++j) {
        const std::uint32_t* sum = sums + std::ptrdiff_t{16} * g + j;
        const Candidate of_row{first + Cell{0, j * step}, corner.heading_step};
        append({0, of_row, {sum[0], sum[4], sum[8], sum[12]}, 0, level});
      }
    }
  }
  /// Bit mask of the nodes of a row that are not pruned.
  [[nodiscard]] unsigned members(const Row& row) const {
    const int columns = (s.half_x - row.corner.offset.x) / side(row.level) + 1;
    unsigned found = 0;
    for (int i = 0; i < std::min(4, columns); ++i)
      found |= static_cast<unsigned>(16 * std::int64_t{row.sums[at(i)]} >= least) << i;
    return found;
  }
  void append(Row row) {
    if (16 * std::int64_t{*std::max_element(row.sums.begin(), row.sums.end())} < least) return;
    row.members = members(row);
    if (row.members == 0) return;
    row.bound = -1e300;
    for (int i = 0; i < 4; ++i) {
      if ((row.members >> i & 1) == 0) continue;
      double bound = s.weight * 16 * row.sums[at(i)];
      if (s.has_prior) {
        const Cell offset = row.corner.offset + Cell{i * side(row.level), 0};
        bound += s.log_prior_bound({offset, row.corner.heading_step}, side(row.level));
      }
      row.bound = std::max(row.bound, bound);
    }
    if (!prunable(row)) scratch.rows_[at(row.level)].push_back(row);
  }

  /// Scores the candidates of a row of nodes of level 0.
  void score(const Candidate& corner) {
    const LikelihoodField& grid = map.grid();
    const kernels::Merged merged = points(0, corner.heading_step);
    const int parts = scratch.merged_[0].parts;
    std::int32_t* index = scratch.index_.data();
    kernel.index(merged.x, merged.y, (merged.ends[parts - 1] + 15) / 16 * 16,
                 corner.offset.x + s.half_x, corner.offset.y + s.half_y, grid.width(),
                 grid.height(), grid.stride(), index);
    // First bounds over 2×2, then the rows that are not pruned.
    std::uint32_t pairs[16], sums[2 * kernels::kBlock];
    kernel.merged_pairs(merged, parts, map.pairs(), grid.stride(), index, pairs);
    for (int r = 0; r < 4; r += 2) {
      const std::uint32_t* pair = pairs + std::ptrdiff_t{4} * r;
      if (16 * std::int64_t{*std::max_element(pair, pair + 8)} < least) continue;
      kernel.merged_rows(merged, parts, grid.data() + std::ptrdiff_t{r} * grid.stride(),
                         grid.stride(), index, sums);
      for (int i = 0; i < 2 * kernels::kBlock; ++i) {
        const Candidate c{corner.offset + Cell{i % kernels::kBlock, r + i / kernels::kBlock},
                          corner.heading_step};
        if (sums[i] < least || c.offset.x > s.half_x || c.offset.y > s.half_y) continue;
        best.offer(s.objective(sums[i], c), sums[i], c);
      }
      if (best.found) least = std::max(least, detail::min_useful_sum(s, best));
    }
  }

  /// Moves the most promising rows of a level, about `count`, to the level's batch; both keep their
  /// order.
  void take_batch(int level, std::size_t count) {
    auto& rows = scratch.rows_[at(level)];
    auto& batch = scratch.batch_[at(level)];
    batch.clear();
    std::erase_if(rows, [&](const Row& row) { return prunable(row); });
    if (rows.size() <= count) return batch.swap(rows);
    constexpr int kBins = 64;
    const auto [low, high] = std::minmax_element(
        rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.bound < b.bound; });
    const double from = low->bound, bins = (kBins - 1) / std::max(high->bound - from, 1e-300);
    const auto bin = [&](const Row& row) { return static_cast<int>((row.bound - from) * bins); };
    std::size_t in_bin[kBins] = {};
    for (const Row& row : rows) ++in_bin[bin(row)];
    int lowest = kBins;
    for (std::size_t sum = 0; sum < count;) sum += in_bin[--lowest];
    auto left = rows.begin();
    for (const Row& row : rows) {
      if (bin(row) >= lowest && batch.size() < 2 * count)
        batch.push_back(row);
      else
        *left++ = row;
    }
    rows.erase(left, rows.end());
  }

  void refine_level(int level) {
    for (std::size_t count = 1; !scratch.rows_[at(level)].empty();
         count = level > 0 ? std::min(kGrowth * count, kMaxRows) : kGrowth * count) {
      take_batch(level, count);
      for (const Row& row : scratch.batch_[at(level)]) {
        if (prunable(row)) continue;
        level == 0 ? score(row.corner) : branch(row.corner, members(row), level - 1);
      }
      if (level > 0) refine_level(level - 1);
    }
  }

  detail::Best run(int level) {
    for (int l = 0; l <= level; ++l) {
      clear(scratch.merged_[at(l)]);
      scratch.rows_[at(l)].clear();
    }
    score({{-(s.half_x & 15), -(s.half_y & 3)}, 0});  // contains the prior
    const int span = 4 * side(level);
    for (int y = -s.half_y; y <= s.half_y; y += span)
      for (int x = -s.half_x; x <= s.half_x; x += 4 * span)
        for (int k = -s.half_k; k <= s.half_k; ++k)
          branch({{x, y}, k}, (1U << std::min(4, (s.half_x - x) / span + 1)) - 1, level);
    refine_level(level);
    return best;
  }
};

Result<std::optional<MatchResult>> BranchAndBoundMatcher::match(const PrecomputationGrids& map,
                                                                const PointSet& points,
                                                                const SE2d& prior,
                                                                const SearchWindow& window,
                                                                const MatchOptions& options) {
  const auto space = detail::plan(map.grid(), points, prior, window, options, kMaxCandidates);
  if (!space) return space.error();
  const detail::CandidateSpace& s = *space;
  const std::size_t padded = points.padded_x_m().size();
  const bool small = std::max(s.half_x, s.half_y) <= 15;
  const std::size_t headings = small ? 1 : s.headings.size();
  const int widest = 2 * std::max(s.half_x, s.half_y) + 1;
  const int level = widest <= 128 ? 1 : 2;
  const double groups = (widest / (4.0 * Search::side(level)) + 1);
  if (headings * padded > (std::size_t{1} << 26) ||
      groups * groups * static_cast<double>(headings) > 1 << 22)
    return Error{ErrorCode::invalid, "match: the search window is too large for these points"};
  for (auto* scratch : {&u_, &v_}) scratch->resize(padded);
  index_.resize(padded + 16);
  const detail::Best best =
      small ? SmallSearch{*this, map, s, points}.run() : Search{*this, map, s, points}.run(level);
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
