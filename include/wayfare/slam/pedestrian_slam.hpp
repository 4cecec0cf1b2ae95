#pragma once

// Submap SLAM on a walker, with pedestrian dead reckoning as its odometry and what the map says fed
// back to it (after Sadruddin 2020, 3.5 and chapter 5): scans are levelled by the unit's attitude.

#include <memory>
#include <optional>

#include <wayfare/core/result.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/pedestrian/map_heading.hpp>
#include <wayfare/pedestrian/pedestrian_parameters.hpp>
#include <wayfare/pedestrian/walk_feedback.hpp>
#include <wayfare/sensors/level_scan.hpp>
#include <wayfare/sensors/marg.hpp>
#include <wayfare/slam/submap_slam.hpp>

namespace wayfare {

struct PedestrianSlamOptions {
  SubmapSlamOptions slam{};
  PedestrianParameters pedestrian{};
  LevelScanOptions level{};
  SO3d q_unit_laser{};   ///< rotates the laser's axes (z up) to the inertial unit's
  bool steps = true;     ///< whether steps are the odometry; else the gyroscope's turn alone
  bool feedback = true;  ///< whether the map corrects the steps' length and direction …
  WalkFeedbackParameters walk{};  ///< … by this
  /// And whether it tells the unit's heading, by which the gyro's bias is found. The magnetometer
  /// is then not used.
  bool heading = true;
  MapHeadingParameters map_heading{};
};

class Pedestrian;

/// Fed in order of time, readings and scans. Not thread-safe.
class PedestrianSlam {
 public:
  explicit PedestrianSlam(const PedestrianSlamOptions& options = {});
  ~PedestrianSlam();
  PedestrianSlam(PedestrianSlam&&) noexcept;
  PedestrianSlam& operator=(PedestrianSlam&&) noexcept;

  /// A reading of the unit on the same carrier as the laser.
  MargUpdateStatus add(const MargSample& sample);
  /// Before there is an attitude a scan is taken for level.
  Result<ScanOutcome> add_scan(const LaserScan& scan);
  Result<void> finish() { return slam().finish(); }

  /// The walker by steps alone, as corrected so far: what SLAM took for odometry.
  [[nodiscard]] const Trajectory& dead_reckoning() const;
  [[nodiscard]] const WalkFeedback& feedback() const;
  /// The filter of attitude and steps (estimate/pedestrian.hpp).
  [[nodiscard]] const Pedestrian& pedestrian() const;
  /// The scan as it was matched, and the map behind.
  [[nodiscard]] const LaserScan& levelled() const;
  [[nodiscard]] const SubmapSlam& slam() const;
  [[nodiscard]] SubmapSlam& slam();

 private:
  class Engine;
  std::unique_ptr<Engine> engine_;
};

/// A whole walk at once.
struct PedestrianSlamRun {
  SubmapSlamRun slam;
  Trajectory dead_reckoning;
  double step_scale = 1.0;  ///< what feedback made of the steps' length
};

/// Scans and readings of one clock, each in order of time. An Error where no scan could be used.
Result<PedestrianSlamRun> run_pedestrian_slam(const Recording& recording, const MargRecording& unit,
                                              PedestrianSlamOptions options = {},
                                              const SlamProgress& progress = {});

}  // namespace wayfare
