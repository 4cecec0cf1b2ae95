#pragma once

#include <functional>
#include <optional>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/map/detection_grid.hpp>
#include <wayfare/map/occupancy_field.hpp>
#include <wayfare/match/branch_and_bound.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/match/pose_proposal.hpp>
#include <wayfare/match/refine.hpp>
#include <wayfare/slam/radar_slam.hpp>

namespace wayfare {

/// A scan found in a particle's map.
struct ScanMatch {
  Gaussian<SE2d> pose;
  double score = 0.0;
  bool widened = false;  ///< found where the motion was believed half as much
};

/// Where a particle comes to be, and what that says of it.
struct Settled {
  SE2d pose;
  double log_factor = 0.0;  ///< of the particle's weight
  double score = 0.0;       ///< of the match, 0 where there was none
  bool matched = false;
};

/// Steps 5 and 6 for one particle and one sensor. Keeps its scratch memory: one a thread.
class SensorStep {
 public:
  SensorStep(const RbpfSensorOptions& options, const PoseProposalOptions& proposal)
      : options_(options), proposal_options_(proposal) {
    proposal_options_.independent_points = options.independent_points;
  }

  /// `expected`: where motion leads to; `tracked`: where the best particle's matches do. Where the
  /// walls agree with the first too little, they are asked about the second.
  [[nodiscard]] Settled settle(const OccupancyGrid& map, const PointSet& points,
                               const Gaussian<SE2d>& expected, const SE2d& tracked, Rng& rng);
  /// The match alone, sought farther about `tracked` where need be.
  [[nodiscard]] std::optional<ScanMatch> track(const OccupancyGrid& map, const PointSet& points,
                                               const Gaussian<SE2d>& expected, const SE2d& tracked);

 private:
  /// Particles differ by less than this in what they make of a motion.
  static constexpr double kNear_m = 0.2;
  static constexpr Angle kNearTurn = Angle::degrees(8.0);

  template <class Elsewhere>
  [[nodiscard]] std::optional<ScanMatch> find(const OccupancyGrid& map, const PointSet& points,
                                              const Gaussian<SE2d>& expected, const SE2d& tracked,
                                              const Elsewhere& elsewhere);
  [[nodiscard]] SearchWindow window_of(const Gaussian<SE2d>& expected) const;
  [[nodiscard]] std::optional<ScanMatch> look(const OccupancyGrid& map, const PointSet& points,
                                              const Gaussian<SE2d>& expected,
                                              const SearchWindow& window, LikelihoodField& view);
  [[nodiscard]] std::optional<ScanMatch> look_wider(const OccupancyGrid& map,
                                                    const PointSet& points,
                                                    const Gaussian<SE2d>& expected);
  [[nodiscard]] bool make_view(const OccupancyGrid& map, const PointSet& points,
                               const SE2d& expected, const FieldReach& reach,
                               LikelihoodField& view);
  [[nodiscard]] MatchOptions match_options(const Eigen::Matrix3d& information) const;
  [[nodiscard]] std::optional<ScanMatch> sharpened(const LikelihoodField& view,
                                                   const PointSet& points,
                                                   const MatchResult& coarse,
                                                   const Gaussian<SE2d>& expected,
                                                   const Eigen::Matrix3d& information) const;
  [[nodiscard]] double explained(const ScanMatch& match, const Gaussian<SE2d>& motion,
                                 const PointSet& points) const;
  [[nodiscard]] double independent(const PointSet& points) const;
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
