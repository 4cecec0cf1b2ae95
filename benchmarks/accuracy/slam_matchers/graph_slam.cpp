#include <wayfare/match/registration.hpp>
#include <wayfare/slam/basic_graph_slam.hpp>

#include "systems.hpp"

namespace wayfare::examples {
namespace {

/// A row for a matcher, with the scores that suit its scale.
template <class M>
System graph_with(const std::string& matcher_name, const M& matcher, Scores own,
                  const Scores& given) {
  GraphSlamOptions options;
  options.tracked_score = given.tracked > 0.0 ? given.tracked : own.tracked;
  options.lost_score = given.lost > 0.0 ? given.lost : own.lost;
  return {"graph SLAM", matcher_name,
          [matcher, options](const Recording& recording, const SlamProgress& progress) {
            return system_run(run_graph_slam(recording, matcher, options, progress));
          }};
}

}  // namespace

std::vector<System> graph_slam_systems(const Scores& scores) {
  return {{"graph SLAM", "default",
           [](const Recording& recording, const SlamProgress& progress) {
             return system_run(run_graph_slam(recording, {}, progress));
           }},
          graph_with("ICP", IcpMatcher(), {0.35, 0.25}, scores),
          graph_with("NDT", NdtMatcher(), {0.55, 0.50}, scores)};
}

}  // namespace wayfare::examples
