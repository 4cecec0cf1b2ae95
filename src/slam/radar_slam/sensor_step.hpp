#pragma once

#include <functional>
#include <optional>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/map/detection_grid.hpp>
#include <wayfare/map/occupancy_field.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/match/pose_proposal.hpp>
#include <wayfare/slam/radar_slam.hpp>

namespace wayfare {

/// A match of a scan with a particle's map.
struct ScanMatch {
  Gaussian<SE2d> pose;
  double score = 0.0;
  bool widened = false;  ///< found with the inflated motion covariance
};

/// A particle's new pose and its weight factor.
struct DrawnPose {
  SE2d pose;
  double log_factor = 0.0;  ///< of the particle's weight
  double score = 0.0;       ///< of the match, 0 where there was none
  bool matched = false;
};

/// Steps 5 and 6 for one particle and one sensor. Has scratch memory: one per thread.
class SensorStep {
 public:
  SensorStep(const RbpfSensorOptions& options, const PoseProposalOptions& proposal)
      : options_(options), proposal_options_(proposal) {
    proposal_options_.independent_points = options.independent_points;
  }

  /// `expected`: predicted by the motion; `tracked`: by the best particle's matches. The second is
  /// searched if the agreement around the first is poor.
  [[nodiscard]] DrawnPose draw_pose(const OccupancyGrid& map, const PointSet& points,
                                    const Gaussian<SE2d>& expected, const SE2d& tracked, Rng& rng);
  /// The match alone, searched in a wide window around `tracked` if necessary.
  [[nodiscard]] std::optional<ScanMatch> track(const OccupancyGrid& map, const PointSet& points,
                                               const Gaussian<SE2d>& expected, const SE2d& tracked);

 private:
  /// Bound on the difference between particles in one motion.
  static constexpr double kNear_m = 0.2;
  static constexpr Angle kNearTurn = Angle::degrees(8.0);

  template <class Elsewhere>
  [[nodiscard]] std::optional<ScanMatch> find(const OccupancyGrid& map, const PointSet& points,
                                              const Gaussian<SE2d>& expected, const SE2d& tracked,
                                              const Elsewhere& elsewhere);
  [[nodiscard]] SearchWindow window_of(const Gaussian<SE2d>& expected) const;
  [[nodiscard]] std::optional<ScanMatch> match_in(const OccupancyGrid& map, const PointSet& points,
                                                  const Gaussian<SE2d>& expected,
                                                  const SearchWindow& window,
                                                  LikelihoodField& view);
  [[nodiscard]] std::optional<ScanMatch> match_wide(const OccupancyGrid& map,
                                                    const PointSet& points,
                                                    const Gaussian<SE2d>& expected);
  [[nodiscard]] bool make_view(const OccupancyGrid& map, const PointSet& points,
                               const SE2d& expected, const FieldReach& reach,
                               LikelihoodField& view);
  [[nodiscard]] MatchOptions match_options(const Eigen::Matrix3d& information) const;
  [[nodiscard]] std::optional<ScanMatch> refined(const LikelihoodField& view,
                                                 const PointSet& points, const MatchResult& coarse,
                                                 const Gaussian<SE2d>& expected,
                                                 const Eigen::Matrix3d& information) const;
  [[nodiscard]] double log_posterior(const ScanMatch& match, const Gaussian<SE2d>& motion,
                                     const PointSet& points) const;
  [[nodiscard]] double point_weight(const PointSet& points) const;
  [[nodiscard]] double log_likelihood(const PointSet& points, const SE2d& pose) const;

  RbpfSensorOptions options_;
  PoseProposalOptions proposal_options_;
  OccupancyFieldMaker fields_;
  DetectionFieldMaker densities_;
  LikelihoodField view_, wide_view_;
  PrecomputationGrids pyramid_;
  CorrelativeMatcher matcher_;
  BranchAndBoundMatcher far_matcher_;
  PoseProposal proposal_;
};

}  // namespace wayfare
