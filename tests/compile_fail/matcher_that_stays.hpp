#pragma once

// A matcher that keeps its prior; with WAYFARE_MUST_FAIL it cannot make a map.

#include <optional>
#include <span>

#include <wayfare/match/scan_matcher.hpp>

struct Stays {
  using Map = int;
#ifndef WAYFARE_MUST_FAIL
  wayfare::Result<int> make_map(std::span<const wayfare::PlacedPoints>) const { return 1; }
#endif
  wayfare::Result<std::optional<wayfare::MatchResult>> match(const int&, const wayfare::PointSet&,
                                                             const wayfare::SE2d& prior,
                                                             const wayfare::SearchWindow&,
                                                             const wayfare::MatchOptions&) const {
    return std::optional(wayfare::MatchResult{.T_map_points = prior});
  }
};
