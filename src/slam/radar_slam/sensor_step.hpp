#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/match/pose_proposal.hpp>
#include <wayfare/slam/detail/check_match.hpp>
#include <wayfare/slam/radar_slam.hpp>

namespace wayfare {

/// A match of a scan with a particle's map.
struct ScanMatch {
  Gaussian<SE2d> pose;
  double score = 0.0;    ///< of the matcher
  double fit = 0.0;      ///< the same of the refined pose
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
  SensorStep(const RbpfSensorOptions& options, const PoseProposalOptions& proposal,
             std::unique_ptr<detail::ParticleMatcher> matcher)
      : options_(options), proposal_options_(proposal), matcher_(std::move(matcher)) {
    proposal_options_.independent_points = options.independent_points;
  }

  /// `expected`: predicted by the motion; `tracked`: by the best particle's matches, `seen` by the
  /// one of this scan. The pose is refined from there, if as good as that one; else it is searched
  /// for around `expected`, then around `tracked` if the agreement is poor.
  [[nodiscard]] DrawnPose draw_pose(const OccupancyGrid& map, const PointSet& points,
                                    const Gaussian<SE2d>& expected, const SE2d& tracked,
                                    const std::optional<ScanMatch>& seen, Rng& rng) {
    const auto about_tracked = [&](const Gaussian<SE2d>& loose) {
      return match_in(map, points, loose, {kNear_m, kNear_m, kNearTurn}, wide_view_);
    };
    auto found = seen ? match_near(map, points, expected, *seen) : std::nullopt;
    if (!found) found = find(map, points, expected, tracked, about_tracked);
    if (found) {
      const auto prior = found->widened ? inflated(tracked, expected) : expected;
      const auto drawn = proposal_.draw(view_, points, found->pose, prior, rng, proposal_options_);
      if (drawn) return {drawn->T_map_points, drawn->log_evidence, found->score, true};
    }
    const SE2d pose = sample(expected, rng);
    return {pose, log_likelihood(points, pose)};
  }

  /// Of the matcher since the last call.
  [[nodiscard]] MatcherErrors take_errors() { return std::exchange(errors_, {}); }

  /// Number of matches that the gate rejected since the last call.
  [[nodiscard]] std::size_t take_gated() { return std::exchange(gated_, 0); }

  /// The match alone, searched in a wide window around `tracked` if necessary.
  [[nodiscard]] std::optional<ScanMatch> track(const OccupancyGrid& map, const PointSet& points,
                                               const Gaussian<SE2d>& expected,
                                               const SE2d& tracked) {
    const auto far_about = [&](const Gaussian<SE2d>& loose) {
      return match_wide(map, points, loose);
    };
    return find(map, points, expected, tracked, far_about);
  }

 private:
  /// Usual difference between particles in one motion, beyond that of their proposals.
  static constexpr double kApart_m = 0.05;
  static constexpr Angle kApartTurn = Angle::degrees(1.0);
  static constexpr double kWorse = 0.05;  ///< in the fit
  /// Bound on the difference.
  static constexpr double kNear_m = 0.2;
  static constexpr Angle kNearTurn = Angle::degrees(8.0);

  /// Refined from `seen`, in the part of the map about it. Nothing if the agreement is worse and
  /// poor, or the proposal reaches beyond that part although a search would have had more.
  [[nodiscard]] std::optional<ScanMatch> match_near(const OccupancyGrid& map,
                                                    const PointSet& points,
                                                    const Gaussian<SE2d>& expected,
                                                    const ScanMatch& seen) {
    const auto extent = [&](const Gaussian<SE2d>& g) -> Eigen::Vector2d {
      const double along = std::sqrt(g.covariance.diagonal().head<2>().maxCoeff());
      return proposal_options_.reach_sigmas * Eigen::Vector2d(along, std::sqrt(g.covariance(2, 2)));
    };
    const FieldReach searched = reach_of(window_of(expected), map);
    const FieldReach near{
        std::min(searched.translation_m, extent(seen.pose).x() + kApart_m + map.resolution_m()),
        std::min(searched.heading_rad, extent(seen.pose).y() + kApartTurn.radians())};
    if (!make_view(map, points, seen.pose.mean, near, view_)) return std::nullopt;
    const std::size_t gated = gated_;
    const auto found =
        refined(view_, points, seen.pose.mean, expected, expected.covariance.inverse());
    gated_ = gated;  // the search that follows counts its own
    if (!found || found->fit < std::min(options_.tracked_score, seen.fit - kWorse))
      return std::nullopt;
    const Eigen::Vector3d off = found->pose.mean.minus(seen.pose.mean);
    const Eigen::Vector2d reached =
        extent(found->pose) + Eigen::Vector2d(off.head<2>().norm(), std::abs(off.z()));
    if ((reached.x() > near.translation_m && near.translation_m < searched.translation_m) ||
        (reached.y() > near.heading_rad && near.heading_rad < searched.heading_rad))
      return std::nullopt;
    return found;
  }

  /// `elsewhere(motion)` searches again if the agreement at `expected` is poor.
  template <class Elsewhere>
  [[nodiscard]] std::optional<ScanMatch> find(const OccupancyGrid& map, const PointSet& points,
                                              const Gaussian<SE2d>& expected, const SE2d& tracked,
                                              const Elsewhere& elsewhere) {
    auto found = match_in(map, points, expected, window_of(expected), view_);
    if (options_.wide_m <= 0 || (found && found->score >= options_.tracked_score)) return found;
    const Gaussian<SE2d> loose = inflated(tracked, expected);
    auto other = elsewhere(loose);
    const ScanMatch stay = found.value_or(ScanMatch{expected, options_.min_score});
    if (!other || log_posterior(*other, loose, points) <
                      log_posterior(stay, loose, points) + options_.wide_margin_nats)
      return found;
    std::swap(view_, wide_view_);
    other->widened = true;
    return other;
  }

  [[nodiscard]] SearchWindow window_of(const Gaussian<SE2d>& expected) const {
    const Eigen::Matrix2d r = expected.mean.rotation().matrix();
    const Eigen::Vector2d variance =
        (r * expected.covariance.topLeftCorner<2, 2>() * r.transpose()).diagonal();
    const Eigen::Vector2d half = (options_.search_sigmas * variance.cwiseMax(0.0).cwiseSqrt())
                                     .cwiseMin(options_.max_correction_m);
    const double turn =
        options_.search_sigmas * std::sqrt(std::max(0.0, expected.covariance(2, 2)));
    return {half.x(), half.y(),
            Angle::radians(std::min(turn, options_.max_turn_correction.radians()))};
  }

  [[nodiscard]] static FieldReach reach_of(const SearchWindow& window, const OccupancyGrid& map) {
    return {std::max(window.half_x_m, window.half_y_m) + map.resolution_m(),
            window.half_heading.radians()};
  }

  [[nodiscard]] std::optional<ScanMatch> match_in(const OccupancyGrid& map, const PointSet& points,
                                                  const Gaussian<SE2d>& expected,
                                                  const SearchWindow& window,
                                                  LikelihoodField& view) {
    if (!make_view(map, points, expected.mean, reach_of(window, map), view)) return std::nullopt;
    const Eigen::Matrix3d information = expected.covariance.inverse();
    const auto coarse = matcher_->match(view, every_kth(points, options_.search_points),
                                        expected.mean, window, match_options(information));
    if (!coarse) errors_.add(coarse.error());
    if (!coarse || !*coarse) return std::nullopt;
    if (auto ok = detail::check_match(**coarse); !ok) {
      errors_.add(ok.error());
      return std::nullopt;
    }
    return refined(view, points, (*coarse)->T_map_points, expected, information, (*coarse)->score);
  }

  /// A wide window, by branch and bound.
  [[nodiscard]] std::optional<ScanMatch> match_wide(const OccupancyGrid& map,
                                                    const PointSet& points,
                                                    const Gaussian<SE2d>& expected) {
    const SearchWindow window{options_.wide_m, options_.wide_m, options_.wide_turn};
    const FieldReach reach{options_.wide_m + map.resolution_m(), options_.wide_turn.radians()};
    if (!make_view(map, points, expected.mean, reach, wide_view_)) return std::nullopt;
    pyramid_.build(wide_view_);
    const Eigen::Matrix3d information = expected.covariance.inverse();
    const auto coarse =
        far_matcher_.match(pyramid_, points, expected.mean, window, match_options(information));
    if (!coarse || !*coarse) return std::nullopt;
    return refined(wide_view_, points, (*coarse)->T_map_points, expected, information,
                   (*coarse)->score);
  }

  [[nodiscard]] bool make_view(const OccupancyGrid& map, const PointSet& points,
                               const SE2d& expected, const FieldReach& reach,
                               LikelihoodField& view) {
    return options_.density
               ? densities_.make(map, points, expected, reach, *options_.density, view).has_value()
               : fields_.make(map, points, expected, reach, options_.field, view).has_value();
  }

  [[nodiscard]] MatchOptions match_options(const Eigen::Matrix3d& information) const {
    MatchOptions result;
    result.min_score = options_.min_score;
    result.prior_information = information;
    result.independent_points = options_.independent_points;
    return result;
  }

  /// Refined from `start`, then combined with the motion as a prior. `score`: that of a search;
  /// without, of the refined pose.
  [[nodiscard]] std::optional<ScanMatch> refined(const LikelihoodField& view,
                                                 const PointSet& points, const SE2d& start,
                                                 const Gaussian<SE2d>& expected,
                                                 const Eigen::Matrix3d& information,
                                                 std::optional<double> score = std::nullopt) {
    const auto fine = refine(view, points, start);
    if (!fine) return std::nullopt;
    const Eigen::Vector3d moved = fine->T_map_points.minus(expected.mean);
    if (std::abs(moved.y()) > options_.gate.lateral_m ||
        std::abs(moved.z()) > options_.gate.turn.radians()) {
      ++gated_;
      return std::nullopt;
    }
    const Eigen::LLT<Eigen::Matrix3d> both(point_weight(points) * fine->information + information);
    if (both.info() != Eigen::Success) return std::nullopt;
    const Eigen::Vector3d back = expected.mean.minus(fine->T_map_points);
    const SE2d pose = fine->T_map_points.plus(both.solve(information * back));
    const Eigen::Vector3d correction = pose.minus(expected.mean);
    if (correction.head<2>().norm() > options_.max_correction_m ||
        std::abs(correction[2]) > options_.max_turn_correction.radians())
      return std::nullopt;
    return ScanMatch{
        {pose, both.solve(Eigen::Matrix3d::Identity())}, score.value_or(fine->score), fine->score};
  }

  /// Log posterior of a match given scan and motion, up to a constant.
  [[nodiscard]] double log_posterior(const ScanMatch& match, const Gaussian<SE2d>& motion,
                                     const PointSet& points) const {
    const double n = point_weight(points) * static_cast<double>(points.size());
    const Eigen::Vector3d off = match.pose.mean.minus(motion.mean);
    return n * (1.0 - match.score) * std::log(options_.field.floor_probability) -
           0.5 * off.dot(motion.covariance.ldlt().solve(off));
  }

  [[nodiscard]] double point_weight(const PointSet& points) const {
    if (!(options_.independent_points > 0.0)) return 1.0;
    return std::min(1.0, options_.independent_points / static_cast<double>(points.size()));
  }

  [[nodiscard]] double log_likelihood(const PointSet& points, const SE2d& pose) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i)
      sum += view_.log_likelihood(
          cell_of(pose * Eigen::Vector2d(points[i].cast<double>()), view_.resolution_m()));
    return point_weight(points) * sum;
  }

  static Gaussian<SE2d> inflated(const SE2d& mean, const Gaussian<SE2d>& motion) {
    return {mean, 4.0 * motion.covariance};
  }

  /// Every k-th point, at most `most`.
  static PointSet every_kth(const PointSet& points, std::size_t most) {
    const std::size_t k = most > 0 ? (points.size() + most - 1) / most : 1;
    PointSet some;
    some.reserve(points.size() / k + 1);
    for (std::size_t i = 0; i < points.size(); i += k) some.push_back(points[i]);
    return some;
  }

  RbpfSensorOptions options_;
  PoseProposalOptions proposal_options_;
  OccupancyFieldMaker fields_;
  DetectionFieldMaker densities_;
  LikelihoodField view_, wide_view_;
  PrecomputationGrids pyramid_;
  std::unique_ptr<detail::ParticleMatcher> matcher_;
  MatcherErrors errors_;
  std::size_t gated_ = 0;
  BranchAndBoundMatcher far_matcher_;
  PoseProposal proposal_;
};

}  // namespace wayfare
