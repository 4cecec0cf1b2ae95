#include <wayfare/match/registration.hpp>
#include <wayfare/slam/hector_slam.hpp>

#include "systems.hpp"

namespace wayfare::examples {
namespace {

/// It closes no loops.
Result<SystemRun> hector_run(const Result<HectorRun>& run) {
  if (!run) return run.error();
  const HectorStatistics& s = run->statistics;
  return SystemRun{run->trajectory, s.scans, s.unmatched_scans, 0, s.matcher_errors};
}

/// A row for a matcher, by the system's own scores unless given.
template <class M>
System hector_with(const std::string& matcher_name, const M& matcher, const Scores& given) {
  HectorSlamOptions options;
  if (given.tracked > 0.0) options.tracked_score = given.tracked;
  if (given.lost > 0.0) options.lost_score = given.lost;
  return {"Hector SLAM", matcher_name,
          [matcher, options](const Recording& recording, const SlamProgress& progress) {
            return hector_run(run_hector_slam(recording, {}, matcher, options, progress));
          }};
}

}  // namespace

std::vector<System> hector_slam_systems(const Scores& scores) {
  return {{"Hector SLAM", "default",
           [](const Recording& recording, const SlamProgress& progress) {
             return hector_run(run_hector_slam(recording, {}, progress));
           }},
          hector_with("ICP", IcpMatcher(), scores),
          hector_with("NDT", NdtMatcher(), scores)};
}

}  // namespace wayfare::examples
