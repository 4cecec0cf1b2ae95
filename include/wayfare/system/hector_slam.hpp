#pragma once

// SLAM by matching every scan to one map at several resolutions (Kohlbrecher et al. 2011): no loop
// closures, no odometry needed where scans follow each other closely.

#include <memory>
#include <optional>
#include <string>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/map/multi_resolution_grid.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/measure/recording.hpp>
#include <wayfare/model/motion_noise.hpp>
#include <wayfare/system/graph_slam.hpp>

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
  double least_score = 0.1;  ///< agreement in [0, 1] below which the motion stands
};

struct HectorStatistics {
  std::size_t scans = 0, unmatched_scans = 0, scans_in_map = 0;
};

/// The system, fed scan by scan. Not thread-safe.
class HectorSlam {
 public:
  explicit HectorSlam(const HectorSlamOptions& options = {});
  ~HectorSlam();
  HectorSlam(HectorSlam&&) noexcept;
  HectorSlam& operator=(HectorSlam&&) noexcept;

  /// Takes the next scan and, where there is any, the odometry at its time. Refused as by
  /// GraphSlam::add_scan.
  Result<ScanOutcome> add_scan(const LaserScan& scan,
                               const std::optional<Transform2<frame::Odom, frame::Base>>& odometry);

  /// One pose a scan taken.
  [[nodiscard]] const Trajectory& trajectory() const;
  [[nodiscard]] const OccupancyGrid& map() const;
  [[nodiscard]] const HectorStatistics& statistics() const;

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

}  // namespace wayfare
