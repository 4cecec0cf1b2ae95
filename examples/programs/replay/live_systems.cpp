#include "live_systems.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <wayfare/logger/messages.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/slam/graph_slam.hpp>

namespace wayfare::examples {
namespace {

/// Waits until each measurement is due.
class Pace {
 public:
  Pace(LogTime first, double speed, const std::atomic<bool>& stop)
      : first_(first), speed_(speed), stop_(stop) {}

  /// Waits until `time`; returns the time since the first, or nothing after `stop`.
  [[nodiscard]] std::optional<double> until(LogTime time) const {
    using Clock = std::chrono::steady_clock;
    const double since_s = to_seconds(time - first_);
    const auto due = begin_ + from_seconds(since_s / speed_);
    while (!stop_ && Clock::now() < due)
      std::this_thread::sleep_until(std::min(due, Clock::now() + std::chrono::milliseconds(50)));
    return stop_ ? std::nullopt : std::optional(since_s);
  }

 private:
  LogTime first_;
  double speed_;
  const std::atomic<bool>& stop_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

void print(double t_s, const SE2d& pose) {
  std::printf("%10.3f s  x %8.2f m  y %8.2f m  heading %7.1f deg\n", t_s, pose.x(), pose.y(),
              pose.heading().degrees());
}

void walk(const MargRecording& samples, double speed, const std::atomic<bool>& stop) {
  Pedestrian pedestrian{PedestrianParameters{}};
  const Pace pace(samples.front().time, speed, stop);
  for (const MargSample& sample : samples) {
    const auto t_s = pace.until(sample.time);
    if (!t_s) break;
    pedestrian.add(sample, [&](const PedestrianPose& p) {
      print(*t_s, SE2d(p.position_m.x(), p.position_m.y(), p.heading));
    });
  }
  std::printf("%zu samples, %zu steps\n", samples.size(),
              static_cast<std::size_t>(pedestrian.report().steps));
}

Result<void> map(const std::vector<LaserScan>& scans, double speed, const std::atomic<bool>& stop) {
  GraphSlam slam;
  const Pace pace(scans.front().time, speed, stop);
  for (const LaserScan& scan : scans) {
    const auto t_s = pace.until(scan.time);
    if (!t_s) break;
    const auto outcome = slam.add_scan(scan, std::nullopt);
    if (outcome) {
      print(*t_s, outcome->T_map_base.raw());
    } else {
      std::fprintf(stderr, "refused: %s\n", outcome.error().to_string().c_str());
    }
  }
  if (auto done = slam.finish(); !done) return done;
  std::printf("%zu scans, %zu loop closures\n", slam.statistics().scans,
              slam.statistics().loop_closures);
  return {};
}

}  // namespace

Result<void> replay_live(const std::string& recording, const LiveOptions& options,
                         const std::atomic<bool>& stop) {
  if (options.system != "graph_slam") {
    const auto logged = logger::read_marg_recording(recording, options.topic);
    if (logged && !logged->samples.empty())
      return walk(logged->samples, options.speed, stop), Result<void>();
    const bool other = options.system.empty() && options.topic.empty() &&
                       (logged || logged.error().code == ErrorCode::not_found);
    if (!other)
      return logged ? Error{ErrorCode::not_found, "contains no sample", recording} : logged.error();
  }
  const auto robot = logger::read_robot_recording(recording);
  if (!robot) return robot.error();
  if (robot->recording.scans.empty())
    return Error{ErrorCode::not_found, "contains no laser scan", recording};
  return map(robot->recording.scans, options.speed, stop);
}

}  // namespace wayfare::examples
