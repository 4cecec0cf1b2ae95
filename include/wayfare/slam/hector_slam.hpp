#pragma once

// SLAM by matching every scan to one map, a multi-resolution grid (Kohlbrecher et al. 2011) or that
// of another matcher: no loop closures, and no odometry needed at a high scan rate. With an
// inertial unit, a navigation filter with six degrees of freedom runs alongside: it levels the
// scans and gives the initial pose of each match, and each match is fused into it by covariance
// intersection.

#include <concepts>
#include <optional>
#include <string>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/detail/owned.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/map/probability_grid.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/motion/differential_drive_model.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/slam/detail/carrier_filter.hpp>
#include <wayfare/slam/detail/matched_map.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare {

/// Map, matching, prior and inertial unit of Hector SLAM.
struct HectorSlamOptions {
  Transform2<frame::Base, frame::Laser> T_base_laser{};  ///< mounting of the laser

  MultiResolutionOptions map{};  ///< grids and inverse sensor model
  /// Heading step of the start poses: between scans a robot may turn beyond the basin of
  /// convergence.
  GaussNewtonOptions match{.max_iterations = 20, .start_step = Angle::degrees(4)};
  double max_range_m = 30.0;      ///< farther returns are not matched
  double point_spacing_m = 0.03;  ///< between neighbouring points; smaller is slower, not sharper

  /// Travel or heading change after which a scan is added to the map. Smaller values extend the map
  /// sooner, and add the pose error of every scan to it.
  double map_travel_m = 0.4;
  Angle map_turn = Angle::degrees(20);  ///< or heading change

  /// Noise of odometry and of the constant-velocity prediction: sets the search window and the
  /// prior along directions that the scene does not constrain.
  MotionNoise odometry{0.06, 0.50, 0.04, Angle::degrees(3.0), 0.4, 0.2};
  /// Without odometry.
  MotionNoise constant_velocity{0.20, 0.50, 0.05, Angle::degrees(8.0), 0.4, 0.2};
  double search_sigmas = 4.0;  ///< half width of the search window, in σ of the prediction
  /// The same of the constant-velocity prediction: in a wider window a scan whose view is blocked
  /// matches elsewhere.
  double velocity_search_sigmas = 2.5;
  /// Errors of a scan's points are correlated: the effective number of points against the prior.
  double independent_points = 100.0;
  double min_score = 0.1;       ///< agreement in [0, 1] below which the predicted pose is kept
  double tracked_score = 0.55;  ///< agreement below which more distant headings are tried as well …
  double lost_score = 0.50;     ///< … and accepted from here on
  PathDrift drift{};  ///< errors of the path through places not seen before: for `covariance` alone

  /// With an inertial unit: rotates the unit's axes to the base's (x forward, y left, z up) …
  SO3d q_base_unit{};
  CarrierFilterParameters carrier{};  ///< noise of the inertial unit's filter
  /// … selects floor and ceiling returns of a tilted scan …
  LevelScanOptions level{};
  /// … least standard deviation of the filter's pose as a prior of the match.
  double min_sigma_m = 0.03;
  Angle min_sigma = Angle::degrees(1);  ///< … and of its heading
  /// Above this standard deviation of the level, scans are not levelled.
  Angle level_sigma = Angle::degrees(5);
};

/// Counts of scans.
struct HectorStatistics {
  std::size_t scans = 0,    ///< accepted
      unmatched_scans = 0,  ///< kept at their predicted pose
      scans_in_map = 0;     ///< added to the map
  /// With an inertial unit: levelled scans, matches fused into the filter, and initialisations of
  /// the filter (after gaps or when the level was lost).
  std::size_t levelled_scans = 0,  ///< levelled
      fused_scans = 0,             ///< fused into the filter
      carrier_starts = 0;          ///< of the filter
  MatcherErrors matcher_errors;    ///< of the matcher's Errors and invalid results
};

/// Hector SLAM by any matcher, as made by a BasicHectorSlam. Processes one scan at a time. Not
/// thread-safe.
class HectorSlamSystem {
 public:
  /// Adds a sample of an inertial unit on the same body, before the scans that end after it
  /// (LaserScan::end_time).
  UpdateStatus add(const ImuSample& sample);

  /// Processes the next scan with the odometry at its time, if any. Errors as GraphSlam::add_scan,
  /// and for a first scan that makes no map. A later one that would make the map too large is left
  /// out of it. An Error for a match that is not valid (see MatcherErrors) changes nothing but the
  /// time of the filter. With an inertial unit, the sweep of a scan whose beams have times of their
  /// own is undone by the filter's motion, and its pose and odometry are those at its end. Where
  /// the matcher returns an Error, or a pose far outside the window, the
  /// scan keeps its predicted one.
  Result<ScanOutcome> add_scan(const LaserScan& scan,
                               const std::optional<Transform2<frame::Odom, frame::Base>>& odometry);

  /// One pose per accepted scan.
  [[nodiscard]] const Trajectory& trajectory() const;
  /// Of the latest pose relative to the first, a right perturbation: x and y along the base's axes,
  /// m², and heading, rad². It is that of the map nearby by `HectorSlamOptions::drift`, then that
  /// of a match, at most `map_travel_m` or `map_turn` ago, or of one before and of the motion since
  /// where scans are not matched. Found again for each call, in a time that grows with the scans in
  /// the map.
  [[nodiscard]] Eigen::Matrix3d covariance() const;
  /// The finest grid.
  [[nodiscard]] const OccupancyGrid& map() const;
  /// Bytes used by grids and tables.
  [[nodiscard]] std::size_t memory_bytes() const;
  /// Counts so far.
  [[nodiscard]] const HectorStatistics& statistics() const;
  /// After a scan the filter is at the scan's time with the match fused. Its state is meaningless
  /// for a time at which `covers` is false.
  [[nodiscard]] const CarrierFilter& carrier() const;

 protected:
  /// With the map of a matcher.
  HectorSlamSystem(const HectorSlamOptions& options, const detail::MakeHectorMap& make_map);

 private:
  class Engine;
  detail::Owned<Engine> engine_;
};

/// Hector SLAM by a matcher `M` that matches in the tables of the system's grids (`M::Map` is
/// ProbabilityPyramid), or makes its own map (MappingMatcher), of all scans and again for each that
/// is added. `HectorSlamOptions::match` is for the default. A match without a covariance is not
/// fused with an inertial unit.
template <SlamMatcher M>
class BasicHectorSlam : public HectorSlamSystem {
 public:
  /// With the matcher of the options.
  explicit BasicHectorSlam(
      const HectorSlamOptions& options = {}) requires std::same_as<M, GaussNewtonMatcher>
      : BasicHectorSlam(M(options.match), options) {}
  /// Copies the matcher.
  explicit BasicHectorSlam(const M& matcher, const HectorSlamOptions& options = {})
      : HectorSlamSystem(options, detail::hector_map(matcher)) {}
};

using HectorSlam = BasicHectorSlam<GaussNewtonMatcher>;  ///< by Gauss-Newton matching in the grids

/// Results for a whole recording.
struct HectorRun {
  Trajectory trajectory;          ///< one pose per accepted scan
  OccupancyGrid map;              ///< the finest grid
  HectorStatistics statistics;    ///< counts
  std::size_t refused_scans = 0;  ///< by add_scan
  std::string first_refusal;      ///< reason for the first of them
  std::size_t memory_bytes = 0;   ///< of the grids and tables at the end
  WallCrossings crossings;        ///< by the map
};

/// Runs Hector SLAM over `recording`, without an inertial unit. Returns an Error if no scan could
/// be
/// used.
Result<HectorRun> run_hector_slam(const Recording& recording, HectorSlamOptions options = {},
                                  const SlamProgress& progress = {});
/// With the samples of an inertial unit on the same clock, in order of time.
Result<HectorRun> run_hector_slam(const Recording& recording, const MargRecording& unit,
                                  HectorSlamOptions options = {},
                                  const SlamProgress& progress = {});

namespace detail {
Result<HectorRun> run(HectorSlamSystem& slam, const Recording& recording, const MargRecording& unit,
                      const SlamProgress& progress);
}  // namespace detail

/// The same by a matcher; `unit` may be empty.
template <SlamMatcher M>
Result<HectorRun> run_hector_slam(const Recording& recording, const MargRecording& unit,
                                  const M& matcher, HectorSlamOptions options = {},
                                  const SlamProgress& progress = {}) {
  options.T_base_laser = recording.T_base_laser;
  BasicHectorSlam<M> slam(matcher, options);
  return detail::run(slam, recording, unit, progress);
}

}  // namespace wayfare
