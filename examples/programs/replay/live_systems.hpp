#pragma once

#include <atomic>
#include <string>

#include <wayfare/core/result.hpp>

namespace wayfare::examples {

struct LiveOptions {
  std::string system;  ///< pedestrian or graph_slam; empty: what the recording has the sensor for
  std::string topic;   ///< of the inertial unit, in a recording of several
  double speed = 1.0;  ///< times real time
};

/// Hands a recording's measurements to a system, each when it would have been, and prints where it
/// says its carrier is. Ends early once `stop` is set.
[[nodiscard]] Result<void> replay_live(const std::string& recording, const LiveOptions& options,
                                       const std::atomic<bool>& stop);

}  // namespace wayfare::examples
