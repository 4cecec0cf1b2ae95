#pragma once

// The systems compared: a row for each matcher of each.

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare::examples {

struct SystemRun {
  Trajectory trajectory;
  std::size_t scans = 0;
  std::size_t unmatched_scans = 0;
  std::size_t loop_closures = 0;
  MatcherErrors matcher_errors = {};
};

struct System {
  std::string name;     ///< "graph SLAM"
  std::string matcher;  ///< "ICP"
  std::function<Result<SystemRun>(const Recording&, const SlamProgress&)> run;
};

/// Scores below which a scan's search is widened and a match is not taken, where they replace those
/// of the systems.
struct Scores {
  double tracked = 0.0, lost = 0.0;  ///< 0: the system's own
};

/// From the run of a system of the library.
template <class Run>
[[nodiscard]] Result<SystemRun> system_run(const Result<Run>& run) {
  if (!run) return run.error();
  const auto& s = run->statistics;
  return SystemRun{run->trajectory, s.scans, s.unmatched_scans, s.loop_closures, s.matcher_errors};
}

[[nodiscard]] std::vector<System> graph_slam_systems(const Scores& scores);
[[nodiscard]] std::vector<System> submap_slam_systems(const Scores& scores);
[[nodiscard]] std::vector<System> hector_slam_systems(const Scores& scores);

}  // namespace wayfare::examples
