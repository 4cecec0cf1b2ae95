#pragma once

#include <atomic>
#include <string>

#include <wayfare/core/result.hpp>

namespace wayfare::examples {

struct LiveOptions {
  std::string system;  ///< pedestrian or graph_slam; empty: by the recording's sensors
  std::string topic;   ///< of the inertial unit, if there are several
  double speed = 1.0;  ///< times real time
};

/// Passes a recording's measurements to a system in real time and prints its poses. Ends early once
/// `stop` is set.
[[nodiscard]] Result<void> replay_live(const std::string& recording, const LiveOptions& options,
                                       const std::atomic<bool>& stop);

}  // namespace wayfare::examples
