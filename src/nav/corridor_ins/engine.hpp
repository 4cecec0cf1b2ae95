#pragma once

#include <optional>
#include <string>

#include <wayfare/nav/corridor_ins.hpp>

#include "nav/corridor_ins/motion_watch.hpp"
#include "nav/corridor_ins/wall_states.hpp"

namespace wayfare {

/// Implementation of CorridorIns.
class CorridorIns::Engine {
 public:
  Engine(const CorridorInsOptions& options, const SE2d& start);

  Result<void> add_motion(const MotionSample& sample);
  Result<CorridorScanUpdate> add_scan(const LaserScan& scan);

  [[nodiscard]] const corridor::Filter& filter() const { return filter_; }
  [[nodiscard]] const CorridorReport& report() const { return report_; }

 private:
  void log_event(LogTime time, std::string what);

  void step(const MotionSample& s, Duration dt);
  /// While the wheels stand the gyro reads bias and noise only.
  void calibrate_at_rest(const CorridorInput& u);

  /// Tracks the walls; acquires new ones if there are none or tracking fails.
  void detect_walls(const LaserScan& scan, const corridor::Predicted& predicted,
                    CorridorScanUpdate& update);
  void add_wall_noise(CorridorWalls& walls) const;
  /// Periodic search for the other side wall, or one across the corridor.
  void search_missing_walls(const LaserScan& scan, const corridor::Predicted& predicted,
                            CorridorScanUpdate& update);

  void use_walls(const corridor::Predicted& predicted, CorridorScanUpdate& update);
  void begin_corridor(const CorridorWalls& detected, CorridorScanUpdate& update);
  /// Constrains nearly parallel or orthogonal walls to be exactly so relative to the first ones.
  void set_square(const CorridorWalls& detected);
  void remember_this_scan(const CorridorWalls& detected);
  /// Updates with direction and both offsets; if rejected, with one side or the other.
  bool use_sides(const corridor::Predicted& p, const CorridorWalls& detected);
  bool use_rows(const corridor::Predicted& p, const CorridorWalls& detected, bool left, bool right);
  bool use_end(const corridor::Predicted& p, const CorridorWalls& detected,
               const CorridorScanUpdate& update);

  CorridorInsOptions options_;
  corridor::Filter filter_;
  CorridorMotion process_;
  corridor::MotionWatch watch_;
  WallDetector detector_;
  corridor::WallStates walls_;
  CorridorReport report_;
  double gates_[4] = {};
  std::optional<LogTime> time_, scan_time_;
  std::optional<double> first_direction_rad_;
  LogTime walls_time_;
  int rejections_ = 0, end_rejections_ = 0;
  bool saturated_ = false;
};

}  // namespace wayfare
