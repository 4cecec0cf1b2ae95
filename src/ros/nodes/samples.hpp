#pragma once

// Queues of samples in order of time.

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/time.hpp>

namespace wayfare::ros {

template <class Samples>
void forget_after(Samples& samples, LogTime time) {
  std::erase_if(samples, [&](const auto& s) { return s.time > time; });
}

/// Drops samples that no later scan can need.
template <class Sample>
void forget_before(std::vector<Sample>& samples, LogTime time) {
  constexpr std::ptrdiff_t kWorthIt = 1000;
  const auto first =
      std::find_if(samples.begin(), samples.end(), [&](const Sample& s) { return s.time >= time; });
  if (first - samples.begin() > kWorthIt) samples.erase(samples.begin(), first - 1);
}

/// For messages.
inline std::string seconds(Duration d) { return std::to_string(to_seconds(d)) + " s"; }

template <class Samples>
std::optional<LogTime> last_of(const Samples& samples) {
  return samples.empty() ? std::nullopt : std::optional(samples.back().time);
}

}  // namespace wayfare::ros
