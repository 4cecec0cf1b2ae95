#pragma once

// Satellite outages of a recording, as given on a command line.

#include <cstddef>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/nav/outage.hpp>

namespace wayfare::examples {

struct NavOutage {
  double start_s = 0.0;  ///< since the unit's first sample
  double length_s = 0.0;
  std::size_t satellites_left = 0;
};

/// "START:LENGTH[:SATELLITES],..." in seconds.
[[nodiscard]] Result<std::vector<NavOutage>> parse_outages(const std::string& text);

/// Removes ranges, and all fixes within an outage whatever the number of satellites left.
void apply_outages(const std::vector<NavOutage>& outages, GnssInsRecording& recording);

/// Starts of `count` outages from `first` to `end`, each at an epoch so that outages have their
/// nominal length.
[[nodiscard]] std::vector<LogTime> outage_starts(LogTime first, LogTime end, Duration length,
                                                 std::size_t count,
                                                 const std::vector<RangeEpoch>& epochs);

}  // namespace wayfare::examples
