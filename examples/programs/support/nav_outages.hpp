#pragma once

// Stretches of a recording without satellites, as asked for on a command line.

#include <cstddef>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/nav/gnss_ins.hpp>

namespace wayfare::examples {

/// Takes satellites away: from `begin` to `end` as many as `satellites_left` stay.
struct NavOutage {
  double start_s = 0.0;  ///< since the unit's first sample
  double length_s = 0.0;
  std::size_t satellites_left = 0;
};

/// "START:LENGTH[:SATELLITES],..." in seconds.
[[nodiscard]] Result<std::vector<NavOutage>> parse_outages(const std::string& text);

/// Fixes within an outage are taken away whatever the number of satellites left.
void apply_outages(const std::vector<NavOutage>& outages, GnssInsRecording& recording);

}  // namespace wayfare::examples
