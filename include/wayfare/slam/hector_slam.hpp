#pragma once

// SLAM by matching every scan to one map at several resolutions (Kohlbrecher et al. 2011): no loop
// closures, no odometry needed where scans follow each other closely. Where there are readings of
// an inertial unit a navigation filter of six degrees of freedom runs beside it: it levels the
// scans and starts each match, and each match enters it by covariance intersection.

#include <memory>
#include <optional>
#include <string>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/map/multi_resolution_grid.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/motion/motion_noise.hpp>
#include <wayfare/sensors/level_scan.hpp>
#include <wayfare/sensors/marg.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/detail/carrier_filter.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare {

struct HectorSlamOptions {
  Transform2<frame::Base, frame::Laser> T_base_laser{};

  MultiResolutionOptions map{};
  /// A robot may turn farther from scan to scan than the widest cells lead back.
  GaussNewtonOptions match{.max_iterations = 20, .start_step = Angle::degrees(4)};
  double max_range_m = 30.0;      ///< farther returns are not matched
  double point_spacing_m = 0.03;  ///< between neighbouring points; smaller: slower, no sharper

  /// Travel or turn after which a scan goes into the map. Less: the map is there sooner, and every
  /// scan's error in it.
  double map_travel_m = 0.4;
  Angle map_turn = Angle::degrees(20);

  /// How far odometry, or going on as before, may be off: how far is searched, and what holds the
  /// robot where the scene says nothing.
  MotionNoise odometry{0.06, 0.50, 0.04, Angle::degrees(3.0), 0.4, 0.2};
  MotionNoise constant_velocity{0.20, 0.50, 0.05, Angle::degrees(8.0), 0.4, 0.2};
  double search_sigmas = 4.0;
  /// A scan's points err together: this many count against the motion.
  double independent_points = 100.0;
  double least_score = 0.1;     ///< agreement in [0, 1] below which the motion stands
  double tracked_score = 0.55;  ///< agreement below which headings farther off are tried as well …
  double lost_score = 0.50;     ///< … and believed from here

  /// With an inertial unit: rotates its axes to the base's (x forward, y left, z up) …
  SO3d q_base_unit{};
  CarrierFilterParameters carrier{};
  /// … what of a tilted scan is floor and ceiling …
  LevelScanOptions level{};
  /// … and how far off the filter's pose may be at least, by the match: m and angle, σ.
  double least_sigma_m = 0.03;
  Angle least_sigma = Angle::degrees(1);
  /// A level less known than this, σ, is none: the scan is taken as it is.
  Angle level_sigma = Angle::degrees(5);
};

struct HectorStatistics {
  std::size_t scans = 0, unmatched_scans = 0, scans_in_map = 0;
  /// With an inertial unit: scans put level by it, matches that entered its filter, and how often
  /// that began anew (pauses, a level that was lost).
  std::size_t levelled_scans = 0, fused_scans = 0, carrier_starts = 0;
};

/// The system, fed scan by scan. Not thread-safe.
class HectorSlam {
 public:
  explicit HectorSlam(const HectorSlamOptions& options = {});
  ~HectorSlam();
  HectorSlam(HectorSlam&&) noexcept;
  HectorSlam& operator=(HectorSlam&&) noexcept;

  /// A reading of an inertial unit on the same carrier, before the scans that follow it.
  UpdateStatus add(const ImuSample& sample);

  /// Takes the next scan and, where there is any, the odometry at its time. Refused as by
  /// GraphSlam::add_scan.
  Result<ScanOutcome> add_scan(const LaserScan& scan,
                               const std::optional<Transform2<frame::Odom, frame::Base>>& odometry);

  /// One pose a scan taken.
  [[nodiscard]] const Trajectory& trajectory() const;
  [[nodiscard]] const OccupancyGrid& map() const;
  [[nodiscard]] const HectorStatistics& statistics() const;
  /// After a scan the filter is at the scan's time, the match taken in. It knows nothing where
  /// `tells_of` that time is false.
  [[nodiscard]] const CarrierFilter& carrier() const;

 private:
  class Engine;
  std::unique_ptr<Engine> engine_;
};

/// A whole recording at once.
struct HectorRun {
  Trajectory trajectory;
  OccupancyGrid map;
  HectorStatistics statistics;
  std::size_t refused_scans = 0;
  std::string first_refusal;
};

Result<HectorRun> run_hector_slam(const Recording& recording, HectorSlamOptions options = {},
                                  const SlamProgress& progress = {});
/// With the readings of an inertial unit of the same clock, in order of time.
Result<HectorRun> run_hector_slam(const Recording& recording, const MargRecording& unit,
                                  HectorSlamOptions options = {},
                                  const SlamProgress& progress = {});

}  // namespace wayfare
