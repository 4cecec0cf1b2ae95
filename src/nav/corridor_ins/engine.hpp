#pragma once

#include <optional>
#include <string>

#include <wayfare/nav/corridor_ins.hpp>

#include "nav/corridor_ins/motion_watch.hpp"
#include "nav/corridor_ins/wall_states.hpp"

namespace wayfare {

/// What corridor dead reckoning does with a motion sample and with a scan.
class CorridorIns::Engine {
 public:
  Engine(const CorridorInsOptions& options, const SE2d& start);

  Result<void> add_motion(const MotionSample& sample);
  Result<CorridorScanUpdate> add_scan(const LaserScan& scan);

  [[nodiscard]] const corridor::Filter& filter() const { return filter_; }
  [[nodiscard]] const CorridorReport& report() const { return report_; }

 private:
  void say(LogTime time, std::string what);

  void step(const MotionSample& s, Duration dt);
  /// All a gyro reads while the wheels stand is bias and noise.
  void calibrate_at_rest(const CorridorInput& u);

  /// Tracking where there is something to track, else, or where that fails, acquisition.
  void see(const LaserScan& scan, const corridor::Predicted& predicted, CorridorScanUpdate& update);
  void roughen(CorridorWalls& walls) const;
  /// From time to time: the other wall, or one across, may have come into view.
  void look_for_more(const LaserScan& scan, const corridor::Predicted& predicted,
                     CorridorScanUpdate& update);

  void take(const corridor::Predicted& predicted, CorridorScanUpdate& update);
  void begin_corridor(const CorridorWalls& seen, CorridorScanUpdate& update);
  /// New walls at right angles to the first ones, or along them, where they nearly are.
  void set_square(const CorridorWalls& seen);
  void remember_this_scan(const CorridorWalls& seen);
  /// Direction and both offsets at once; where that is refused, with one side and with the other.
  bool use_sides(const corridor::Predicted& p, const CorridorWalls& seen);
  bool use_rows(const corridor::Predicted& p, const CorridorWalls& seen, bool left, bool right);
  bool take_end(const corridor::Predicted& p, const CorridorWalls& seen,
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
