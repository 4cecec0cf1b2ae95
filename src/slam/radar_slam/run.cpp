#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <wayfare/sync/augmented_scans.hpp>
#include <wayfare/sync/odometry_track.hpp>
#include <wayfare/system/radar_slam.hpp>

#include "../gather_radar.hpp"
#include "dead_reckoning.hpp"

namespace wayfare {
namespace {

/// What goes wrong is counted, and the first of it kept.
struct Refusals {
  std::size_t count = 0;
  std::string first = {};

  template <class T>
  void add(const Result<T>& outcome, const char* sensor, LogTime time) {
    if (outcome || count++ > 0) return;
    first = std::string(sensor) + " scan at " + std::to_string(time.seconds()) +
            " s: " + outcome.error().message;
  }
  void add_late(std::size_t measurements) {
    if (measurements == 0) return;
    if (count == 0) first = std::to_string(measurements) + " measurements late or doubled";
    count += measurements;
  }
};

/// A sensor that has fallen silent, or sees nothing.
class Watch {
 public:
  explicit Watch(std::string what) : what_(std::move(what)) {}
  void saw(LogTime time) { last_ = time; }
  void tell(LogTime now, FaultLog& faults) const {
    constexpr double kLongest_s = 3.0;
    if (last_) faults.tell(what_, to_seconds(now - *last_) > kLongest_s, now);
  }

 private:
  std::string what_;
  std::optional<LogTime> last_;
};

struct Feed {
  Feed(RadarSlam& system, SlamSensors of) : slam(system), sensors(of) {}

  RadarSlam& slam;
  SlamSensors sensors;
  FaultLog faults;
  Refusals refusals;
  Watch laser{"no LiDAR returns"}, radar{"no radar points"};
  double gyro_bias_rad_s = 0.0;

  RbpfOutcome lidar_scan(const LaserScan& scan) {
    if (sensors == SlamSensors::radar) return {};
    bool returned = false;
    for (std::size_t i = 0; i < scan.ranges_m.size() && !returned; ++i) returned = scan.returned(i);
    if (returned) laser.saw(scan.time);
    return taken(slam.add_lidar(scan), "LiDAR", scan.time);
  }
  RbpfOutcome radar_scan(LogTime time, const PointSet& points) {
    if (sensors == SlamSensors::lidar) return {};
    if (!points.empty()) radar.saw(time);
    return taken(slam.add_radar(time, points), "radar", time);
  }
  RbpfOutcome taken(const Result<RbpfOutcome>& outcome, const char* sensor, LogTime time) {
    refusals.add(outcome, sensor, time);
    return outcome ? *outcome : RbpfOutcome{};
  }
  void watch(LogTime now) {
    laser.tell(now, faults);
    radar.tell(now, faults);
  }
};

/// From wheels and gyro, on the common time base (steps 1 and 2).
void feed_steps(const Recording& recording, const DeadReckoningOptions& reckoning, Feed& feed,
                const SlamProgress& progress) {
  SyncStatistics refused;
  const auto steps = synchronise(recording, sync_params(recording), &refused);
  feed.refusals.add_late(refused.refused_late);
  DeadReckoner reckoner(reckoning, recording.wheel_base_m);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const SyncedStep& step = steps[i];
    (void)feed.slam.move(reckoner.increment(step, feed.faults));
    if (step.laser) reckoner.learn(feed.lidar_scan(*step.laser));
    if (step.radar) reckoner.learn(feed.radar_scan(step.radar->time, step.radar->points));
    feed.watch(step.time);
    if (progress && !progress(static_cast<double>(i + 1) / static_cast<double>(steps.size())))
      break;
  }
  feed.gyro_bias_rad_s = reckoner.gyro_bias_rad_s();
}

Gaussian<SE2d> believed(const SE2d& increment, const MotionNoise& noise) {
  const double d = increment.translation().norm();
  const double turn = std::abs(increment.heading().radians());
  const auto square = [](double x) { return x * x; };
  const double along = square(noise.translation_floor_m) + square(noise.translation_per_m * d) +
                       square(noise.translation_per_rad_m * turn);
  const double heading = square(noise.heading_floor.radians()) +
                         square(noise.heading_per_rad * turn + noise.heading_per_m_rad * d);
  return {increment, Eigen::Vector3d(along, along, heading).asDiagonal()};
}

/// From poses of odometry at the scans' times; without them the robot stays about where it was.
void feed_odometry(const Recording& recording, const DeadReckoningOptions& reckoning, Feed& feed,
                   const SlamProgress& progress) {
  const OdometryTrack track(recording.odometry);
  const MotionNoise blind{0.15, 0.0, 0.0, Angle::degrees(8.0), 0.0, 0.0};
  std::optional<SE2d> last;
  const auto move_to = [&](LogTime time, const char* sensor) {
    const auto now = track.at(time);
    const SE2d pose = now ? now->raw() : SE2d();
    if (last)
      feed.refusals.add(
          feed.slam.move(believed(last->inverse() * pose, now ? reckoning.odometry : blind)),
          sensor, time);
    last = pose;
  };
  const auto radar = feed.sensors == SlamSensors::lidar ? std::vector<GatheredRadar>()
                                                        : gather_radar(recording, track);
  const auto& scans = recording.scans;
  const std::size_t lidar = feed.sensors == SlamSensors::radar ? 0 : scans.size();
  for (std::size_t i = 0, r = 0; i < lidar || r < radar.size();) {
    const bool by_radar = i == lidar || (r < radar.size() && radar[r].time < scans[i].time);
    const LogTime time = by_radar ? radar[r].time : scans[i].time;
    move_to(time, by_radar ? "motion to radar" : "motion to LiDAR");
    if (by_radar)
      (void)feed.radar_scan(time, radar[r++].points);
    else
      (void)feed.lidar_scan(scans[i++]);
    feed.watch(time);
    const double done = static_cast<double>(i + r) / static_cast<double>(lidar + radar.size());
    if (progress && !progress(done)) break;
  }
}

}  // namespace

Result<RadarSlamRun> run_radar_slam(const Recording& recording, RadarSlamOptions options,
                                    SlamSensors sensors, const SlamProgress& progress,
                                    const DeadReckoningOptions& reckoning) {
  options.T_base_laser = recording.T_base_laser;
  if (recording.wheels.empty() && recording.odometry.empty()) {
    // Where nothing says how far the robot went, what it sees must, and often.
    options.update_time_s = std::min(options.update_time_s, 1.0);
  } else if (recording.wheels.empty()) {
    options.update_travel_m = reckoning.odometry_update_travel_m;
    options.update_turn = reckoning.odometry_update_turn;
    options.match_between = true;
  }
  RadarSlam slam(options);
  Feed feed(slam, sensors);
  if (recording.wheels.empty())
    feed_odometry(recording, reckoning, feed, progress);
  else
    feed_steps(recording, reckoning, feed, progress);
  if (slam.statistics().taken_up == 0)
    return Error{ErrorCode::invalid,
                 "no scan could be used" +
                     (feed.refusals.count > 0 ? "; " + feed.refusals.first : std::string())};
  RadarSlamRun run{slam.trajectory(),
                   slam.lidar_map(),
                   slam.radar_map(),
                   slam.statistics(),
                   {},
                   {},
                   feed.faults.faults(Duration(500'000'000)),
                   feed.gyro_bias_rad_s,
                   feed.refusals.count,
                   std::move(feed.refusals.first)};
  for (const auto& particle : slam.particles())
    run.particles.push_back(
        {run.trajectory.back().time, Transform2<frame::Map, frame::Base>(particle.pose)});
  run.log_weights.assign(slam.log_weights().begin(), slam.log_weights().end());
  return run;
}

}  // namespace wayfare
