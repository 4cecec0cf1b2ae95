#pragma once

// What a matcher of any type must not return.

#include <wayfare/core/result.hpp>
#include <wayfare/match/scan_matcher.hpp>

namespace wayfare::detail {

/// Refuses a match that is not finite, or whose covariance is none.
[[nodiscard]] Result<void> check_match(const MatchResult& match);

}  // namespace wayfare::detail
