#pragma once

#include <algorithm>

#include <Eigen/Core>
#include <Eigen/LU>

#include <wayfare/match/scan_matcher.hpp>
#include <wayfare/slam/detail/graph_slam/loss_detector.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/detail/graph_slam/placement.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/graph_slam.hpp>

namespace wayfare::detail {

/// Pose of a scan, and whether it required a wider search.
struct Track {
  Placement placement;
  bool widened = false;
  bool sure = true;  ///< false: as good as a match at a wrong pose may be
};

/// Matches scans to a local map of the latest nodes; how is for `Matching` to say (see
/// FieldMatching and MatcherMatching).
template <class Matching>
class Tracker {
 public:
  static constexpr std::size_t kFewestPoints = 10;  ///< of a scan that is matched

  Tracker(const GraphSlamOptions& options, const Matching& matching)
      : options_(options), matching_(matching) {}

  /// The scan's pose by the local map; `prior`, predicted by `motion`, if nothing agrees. An Error
  /// is that of a result of the matching that is not valid.
  [[nodiscard]] Result<Track> place(const NodeMap& nodes, const PointSet& points, const SE2d& prior,
                                    const Motion& motion, const Gap& gap) {
    if (points.size() < kFewestPoints) return Track{{prior}};
    if (!motion.measured && gap.is_break()) return Track{{prior}, true, false};
    const bool is_close = motion.measured && motion.sigma.head<2>().maxCoeff() < kClose_m;
    if (maps_are_old_ || is_close != rendered_close_) matching_.render(nodes, is_close);
    maps_are_old_ = false;
    rendered_close_ = is_close;
    if (!motion.measured && gap.is_wide()) return place_far(nodes, points, prior, motion, gap);
    const Eigen::Matrix3d information = motion.covariance().inverse();
    const Eigen::Vector3d reach = (3.0 * motion.sigma).cwiseMin(0.5);
    auto best = matching_.search(points, prior, {reach[0], reach[1], Angle::radians(reach[2])},
                                 information);
    const bool widened = best && best->score < options_.tracked_score;
    if (widened) best = search_wider(nodes, points, prior, information, *best);
    if (!best) return best.error();
    if (best->score < options_.lost_score)
      return Track{{prior, best->score}, widened, motion.measured && gap.is_wide()};
    // After a scan that was not matched the robot may be elsewhere.
    const bool may_be_elsewhere = !motion.measured || (gap.is_doubted() && !gap.is_wide());
    if (may_be_elsewhere && widened && best->score < options_.wide_loop_score)
      return Track{{prior, best->score}, true, false};
    const Placement sharp = matching_.refine(points, *best);
    if (!motion.measured && !is_usual(sharp, kYoungShare))
      return Track{{prior, best->score}, true, false};
    return Track{{settle(sharp, prior, motion), best->score, sharp.spread}, widened};
  }

  /// Of the matching since the last call.
  [[nodiscard]] MatcherErrors take_errors() { return matching_.take_errors(); }

  /// Score of usual scans in the refinement map, where they are far apart.
  [[nodiscard]] double& usual_sharp() { return usual_sharp_; }

  /// A node was added, or nodes have moved.
  void nodes_changed() { maps_are_old_ = true; }

  /// Frees the memory of the local maps; the next scan renders them again.
  void release() {
    matching_.release();
    nodes_changed();
  }

 private:
  /// Without odometry, scans far apart: surely where the search at all poses in reach finds one
  /// that agrees, and none with another heading.
  Result<Track> place_far(const NodeMap& nodes, const PointSet& points, const SE2d& prior,
                          const Motion& motion, const Gap& gap) {
    const Eigen::Vector3d sigma = gap.sigma();
    const Eigen::Vector3d half = gap.reach().cwiseMin(4.0 * sigma);
    const SearchWindow window{half[0], half[1], Angle::radians(half[2])};
    auto best = matching_.search_far(points, prior, window, information_of(sigma));
    if (!best) return best.error();
    if (best->score < options_.lost_score) return Track{{prior, best->score}, true, false};
    const Placement sharp = matching_.refine(points, *best);
    const auto other = matching_.rival(points, prior, window, information_of(sigma), *best);
    if (!other) return other.error();
    const Eigen::Vector3d moved = sharp.T_map_points.minus(prior).cwiseQuotient(sigma);
    const bool unusual = moved.cwiseAbs().maxCoeff() > kUnusual;
    const double needed = unusual ? options_.wide_loop_score : 0.0;
    const bool sure = !*other && best->score >= needed && is_usual(sharp, share_needed(nodes, gap));
    if (!sure) return Track{{prior, best->score}, true, false};
    return Track{{settle(sharp, prior, {motion.increment, sigma}), best->score, sharp.spread},
                 false};
  }

  /// Of the usual score in the refinement map: more after a scan that was not matched, less where
  /// the map has seen little.
  static double share_needed(const NodeMap& nodes, const Gap& gap) {
    if (gap.is_doubted()) return kShareInDoubt;
    const bool is_young = nodes.latest() < nodes.first_of_piece(nodes.pieces() - 1) + kYoungNodes;
    return is_young ? kYoungShare : kUsualShare;
  }
  /// Without odometry, whether a scan agrees with the refinement map as others did.
  bool is_usual(const Placement& sharp, double share) {
    if (!(sharp.score > share * usual_sharp_)) return false;
    usual_sharp_ += kGain * (sharp.score - usual_sharp_);
    return true;
  }

  /// First in a wider window at the prediction, then at all headings in a map of all nodes nearby.
  Result<Placement> search_wider(const NodeMap& nodes, const PointSet& points, const SE2d& prior,
                                 const Eigen::Matrix3d& information, Placement best) {
    const auto wide = matching_.search(points, prior, {0.8, 0.8, 50_deg}, 0.25 * information);
    if (!wide) return wide.error();
    if (wide->score > best.score + 0.10) best = *wide;
    if (best.score >= options_.lost_score) return best;
    const auto anywhere = matching_.search_around(nodes, points, prior);
    if (!anywhere) return anywhere.error();
    if (anywhere->score > best.score + 0.30) best = *anywhere;
    return best;
  }

  GraphSlamOptions options_;
  Matching matching_;
  bool maps_are_old_ = true, rendered_close_ = false;
  /// Standard deviation of a prediction up to which wide cells of the blurred map do no harm.
  static constexpr double kClose_m = 0.06;
  /// Beyond these standard deviations a match needs the score of a wide loop. Errors of predictions
  /// are a third of them.
  static constexpr double kUnusual = 2.5;
  /// Least score in the refinement map, of that of other scans: it depends on how far apart they
  /// are.
  static constexpr double kUsualShare = 0.5, kYoungShare = 0.3, kShareInDoubt = 0.7, kGain = 0.05;
  static constexpr int kYoungNodes = 4;  // of a piece whose map has seen little
  double usual_sharp_ = 0.4;
};

}  // namespace wayfare::detail
