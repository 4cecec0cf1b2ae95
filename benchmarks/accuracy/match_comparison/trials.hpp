#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pairs.hpp"

namespace wayfare::examples {

/// How far from the truth a matcher is started: so far in a random direction, turned by so much
/// either way.
struct StartError {
  double offset_m;
  Angle turn;
};

struct TrialOptions {
  std::vector<StartError> starts{{0.05, Angle::degrees(2)},
                                 {0.1, Angle::degrees(5)},
                                 {0.2, Angle::degrees(10)},
                                 {0.4, Angle::degrees(20)},
                                 {0.8, Angle::degrees(30)}};
  /// A match this near the truth counts.
  double near_m = 0.1;
  Angle near_turn = Angle::degrees(2);
  /// Where matches are sought: a tenth more than the start's error.
  double max_range_m = 20.0;
  std::uint64_t seed = 1;
};

/// What became of one matcher's trials.
struct MatcherTrials {
  std::string name;
  std::vector<double> success;       ///< share of the pairs, for each start error
  double median_error_m = 0.0;       ///< of the successful from the smallest start error
  double map_us = 0.0;               ///< making its map of a scan, mean
  std::vector<double> microseconds;  ///< a match, mean, for each start error
};

/// Every matcher on every pair from every start error; progress is called with the fraction done.
[[nodiscard]] std::vector<MatcherTrials> run_trials(const std::vector<ScanPair>& pairs,
                                                    const TrialOptions& options,
                                                    const std::function<void(double)>& progress);

}  // namespace wayfare::examples
