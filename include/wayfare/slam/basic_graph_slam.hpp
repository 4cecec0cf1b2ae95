#pragma once

// Graph SLAM with a scan matcher of your own. GraphSlam of graph_slam.hpp, with the matcher of the
// library, is compiled once and faster to include.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <wayfare/match/scan_matcher.hpp>
#include <wayfare/slam/detail/graph_slam/engine.hpp>
#include <wayfare/slam/detail/graph_slam/matcher_matching.hpp>
#include <wayfare/slam/detail/graph_slam/run_over.hpp>
#include <wayfare/slam/graph_slam.hpp>

namespace wayfare {

/// Graph SLAM that places scans by `M`, in maps that it makes of the latest nodes: at the pose
/// predicted from odometry, with the covariance and this prediction as prior, in a wider window if
/// the score is below `tracked_score`, and last at a pose searched in a likelihood field of all
/// nodes nearby. Loop closures are searched in likelihood fields, as by GraphSlam, and accepted if
/// the matcher, started there, finds a pose with a score of `tracked_score`.
///
/// In the options, `tracked_score` and `lost_score` are of the matcher's scale; those of cells,
/// blurs and loops are of the likelihood fields. An Error of the matcher, or no match, leaves the
/// scan at its predicted pose, unmatched. A result that is not valid (see MatcherErrors) is an
/// Error of `add_scan`, which then changes nothing. At a loop either refuses the closure. All but
/// the Errors of `add_scan` are counted in the statistics. Where the matcher gives neither
/// constraint nor covariance, scenes are taken to constrain every direction.
///
/// Same results for any number of threads; loops are matched by copies of the matcher.
template <MappingMatcher M>
class BasicGraphSlam {
 public:
  /// Copies the matcher. Negative counts of the options are taken as zero.
  explicit BasicGraphSlam(const M& matcher, const GraphSlamOptions& options = {})
      : engine_(options, [&](const GraphSlamOptions& valid) {
          return detail::MatcherMatching<M>(valid, matcher);
        }) {}

  // As those of GraphSlam.
  /// As GraphSlam::add_scan; also an Error for a result of the matcher that is not valid.
  Result<ScanOutcome> add_scan(
      const LaserScan& scan, const std::optional<Transform2<frame::Odom, frame::Base>>& odometry) {
    return engine_.add_scan(scan, odometry);
  }
  /// As GraphSlam::finish.
  Result<void> finish() { return engine_.finish(); }
  /// As GraphSlam::trajectory.
  [[nodiscard]] Trajectory trajectory() const { return engine_.trajectory(); }
  /// As GraphSlam::graph.
  [[nodiscard]] const PoseGraph2& graph() const { return engine_.graph(); }
  /// Counts so far.
  [[nodiscard]] const GraphSlamStatistics& statistics() const { return engine_.statistics(); }
  /// As GraphSlam::map.
  [[nodiscard]] OccupancyGrid map(const OccupancyGridOptions& shape = {},
                                  const InverseLidarModel& model = {}) const {
    return engine_.map(shape, model);
  }

  /// Of every third node's rays through the walls of its map.
  [[nodiscard]] WallCrossings wall_crossings(const OccupancyGrid& map) const {
    return engine_.wall_crossings(map);
  }

  /// As GraphSlam::save; the state does not tell the matcher.
  [[nodiscard]] std::vector<std::uint8_t> save() { return engine_.save(); }
  /// Continues from a saved state, with the matcher and the options it was saved under. Errors as
  /// GraphSlam::restore.
  [[nodiscard]] static Result<BasicGraphSlam> restore(std::span<const std::uint8_t> bytes,
                                                      const M& matcher,
                                                      const GraphSlamOptions& options = {}) {
    BasicGraphSlam slam(matcher, options);
    if (auto ok = slam.engine_.restore(bytes); !ok) return ok.error();
    return slam;
  }

 private:
  detail::GraphSlamEngine<detail::MatcherMatching<M>> engine_;
};

/// Runs graph SLAM with a matcher over `recording`, as without.
template <MappingMatcher M>
Result<GraphSlamRun> run_graph_slam(const Recording& recording, const M& matcher,
                                    GraphSlamOptions options = {},
                                    const SlamProgress& progress = {},
                                    std::span<const std::uint8_t> saved = {},
                                    std::vector<std::uint8_t>* state = nullptr) {
  options.T_base_laser = recording.T_base_laser;
  if (saved.empty())
    return detail::run_over(BasicGraphSlam<M>(matcher, options), recording, progress, state);
  auto slam = BasicGraphSlam<M>::restore(saved, matcher, options);
  return slam ? detail::run_over(*std::move(slam), recording, progress, state) : slam.error();
}

}  // namespace wayfare
