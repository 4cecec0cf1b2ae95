#pragma once

// Submap SLAM for a pedestrian, with pedestrian dead reckoning as odometry and feedback from the
// map to it (after Sadruddin 2020, 3.5 and chapter 5). Scans are levelled with the unit's attitude.

#include <optional>

#include <wayfare/core/detail/owned.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/pedestrian/parameters.hpp>
#include <wayfare/pedestrian/walk_feedback.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/slam/submap_slam.hpp>

namespace wayfare {

/// SLAM, dead reckoning and feedback between them.
struct PedestrianSlamOptions {
  SubmapSlamOptions slam{};           ///< of the scans
  PedestrianParameters pedestrian{};  ///< of steps and attitude
  LevelScanOptions level{};           ///< floor, ceiling and beams of a levelled scan
  SO3d q_unit_laser{};                ///< rotates the laser's axes (z up) to the inertial unit's
  bool steps = true;     ///< whether odometry comes from steps; else only the gyroscope's turn
  bool feedback = true;  ///< whether the map corrects step length and direction …
  WalkFeedbackParameters walk{};  ///< … with these parameters
  /// Whether the map also gives heading measurements, from which the gyro bias is estimated. The
  /// magnetometer is then not used.
  bool heading = true;
  MapHeadingParameters map_heading{};  ///< noise of these measurements
};

/// Takes samples and scans in order of time. Not thread-safe.
class PedestrianSlam {
 public:
  /// Without samples and scans.
  explicit PedestrianSlam(const PedestrianSlamOptions& options = {});

  /// Adds a sample of the unit on the same body as the laser.
  MargUpdateStatus add(const MargSample& sample);
  /// A scan before the first attitude is taken as level. Where its beams have times of their own,
  /// the sweep is undone by the attitude and the velocity, by the map or by the steps; add the
  /// samples up to `scan.end_time()` first. Errors as SubmapSlam::add_scan.
  Result<ScanOutcome> add_scan(const LaserScan& scan);
  /// As SubmapSlam::finish.
  Result<void> finish() { return slam().finish(); }

  /// The trajectory by dead reckoning with the corrections so far: the odometry of the SLAM.
  [[nodiscard]] const Trajectory& dead_reckoning() const;
  /// Step scale and walking direction by the map.
  [[nodiscard]] const WalkFeedback& feedback() const;
  /// The filter of attitude and steps.
  [[nodiscard]] const Pedestrian& pedestrian() const;
  /// The scan as it was matched.
  [[nodiscard]] const LaserScan& levelled() const;
  /// Of the levelled scans.
  [[nodiscard]] const SubmapSlam& slam() const;
  /// For its settings between scans.
  [[nodiscard]] SubmapSlam& slam();

 private:
  class Engine;
  detail::Owned<Engine> engine_;
};

/// Results for a whole walk.
struct PedestrianSlamRun {
  SubmapSlamRun slam;         ///< trajectory, graph and map
  Trajectory dead_reckoning;  ///< with the corrections applied as they came
  double step_scale = 1.0;    ///< factor on the step length, as estimated by the feedback
};

/// Scans and samples on one clock, each in order of time. Returns an Error if no scan could be
/// used.
Result<PedestrianSlamRun> run_pedestrian_slam(const Recording& recording, const MargRecording& unit,
                                              PedestrianSlamOptions options = {},
                                              const SlamProgress& progress = {});

}  // namespace wayfare
