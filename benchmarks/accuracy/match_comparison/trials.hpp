#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pairs.hpp"

namespace wayfare::examples {

/// Error of the initial pose: an offset in a random direction, and a rotation of random sign.
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
  /// Largest errors of a success.
  double near_m = 0.1;
  Angle near_turn = Angle::degrees(2);
  double max_range_m = 20.0;
  std::uint64_t seed = 1;
};

/// Results of one matcher.
struct MatcherTrials {
  std::string name;
  std::vector<double> success;       ///< share of the pairs, for each initial error
  double median_error_m = 0.0;       ///< of the successes with the smallest initial error
  double map_us = 0.0;               ///< mean time to build the map of a scan
  std::vector<double> microseconds;  ///< mean time of a match, for each initial error
};

/// Every matcher on every pair with every initial error; `progress` is called with the fraction
/// done.
[[nodiscard]] std::vector<MatcherTrials> run_trials(const std::vector<ScanPair>& pairs,
                                                    const TrialOptions& options,
                                                    const std::function<void(double)>& progress);

}  // namespace wayfare::examples
