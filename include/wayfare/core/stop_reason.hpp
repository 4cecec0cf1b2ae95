#pragma once

// Why an iterative minimisation ended.

#include <string_view>

namespace wayfare {

enum class StopReason {
  converged,       ///< the gain fell below its threshold
  max_iterations,  ///< the estimate is the best so far
  stopped,         ///< by the progress callback
  no_progress,     ///< no damping up to its maximum lowers the cost
};

[[nodiscard]] constexpr std::string_view to_string(StopReason reason) {
  switch (reason) {
    case StopReason::converged:
      return "converged";
    case StopReason::max_iterations:
      return "iteration limit";
    case StopReason::stopped:
      return "stopped on request";
    case StopReason::no_progress:
      return "no step lowers the cost";
  }
  return "";
}

}  // namespace wayfare
