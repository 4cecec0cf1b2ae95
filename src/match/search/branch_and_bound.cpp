#include <wayfare/match/correlative.hpp>

#include <algorithm>

#include "match/search/small_search.hpp"
#include "match/search/wide_search.hpp"

namespace wayfare {

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
