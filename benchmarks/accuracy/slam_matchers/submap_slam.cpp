#include <wayfare/match/registration.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "systems.hpp"

namespace wayfare::examples {
namespace {

/// A row for a matcher. The system's own scores suit ICP and NDT.
template <class M>
System submap_with(const std::string& matcher_name, const M& matcher, const Scores& given) {
  SubmapSlamOptions options;
  if (given.tracked > 0.0) options.tracked_score = given.tracked;
  if (given.lost > 0.0) options.lost_score = given.lost;
  return {"submap SLAM", matcher_name,
          [matcher, options](const Recording& recording, const SlamProgress& progress) {
            return system_run(run_submap_slam(recording, matcher, options, progress));
          }};
}

}  // namespace

std::vector<System> submap_slam_systems(const Scores& scores) {
  return {{"submap SLAM", "default",
           [](const Recording& recording, const SlamProgress& progress) {
             return system_run(run_submap_slam(recording, {}, progress));
           }},
          submap_with("ICP", IcpMatcher(), scores),
          submap_with("NDT", NdtMatcher(), scores)};
}

}  // namespace wayfare::examples
