#include <wayfare/slam/radar_slam.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/slam/detail/scans.hpp>

#include "slam/radar_slam/dead_reckoning.hpp"
#include "sync/gather_radar.hpp"

namespace wayfare {
namespace {

/// A queue in contiguous memory.
template <class Measurement>
class Pending {
 public:
  void push(const Measurement& m) { all_.push_back(m); }
  void pop(std::size_t n) {
    popped_ += n;
    if (2 * popped_ < all_.size()) return;
    all_.erase(all_.begin(), all_.begin() + static_cast<std::ptrdiff_t>(popped_));
    popped_ = 0;
  }
  [[nodiscard]] bool empty() const { return popped_ == all_.size(); }
  [[nodiscard]] const Measurement& front() const { return all_[popped_]; }
  [[nodiscard]] std::span<const Measurement> span() const {
    return std::span<const Measurement>(all_).subspan(popped_);
  }

 private:
  std::vector<Measurement> all_;
  std::size_t popped_ = 0;
};

Gaussian<SE2d> with_noise(const SE2d& increment, const MotionNoise& noise) {
  const double d = increment.translation().norm();
  const double turn = std::abs(increment.heading().radians());
  const auto square = [](double x) { return x * x; };
  const double along = square(noise.translation_floor_m) + square(noise.translation_per_m * d) +
                       square(noise.translation_per_rad_m * turn);
  const double heading = square(noise.heading_floor.radians()) +
                         square(noise.heading_per_rad * turn + noise.heading_per_m_rad * d);
  return {increment, Eigen::Vector3d(along, along, heading).asDiagonal()};
}

enum Stream : std::size_t { kOdometrySamples, kRadarFrames, kLaserScans, kStreams };

}  // namespace

RadarSlamOptions RadarSlamStream::filter_options(const RadarSlamStreamOptions& o) {
  RadarSlamOptions slam = o.slam;
  if (o.motion == MotionSource::wheels) return slam;
  slam.lidar.grid.resolution_m = o.reckoning.odometry_cell_m;
  slam.lidar.field.sigma_m = o.reckoning.odometry_point_sigma_m;
  slam.lidar.independent_points = o.reckoning.odometry_independent_points;
  if (o.motion == MotionSource::none) {
    // Without odometry the motion must come from frequent scan matches.
    slam.update_time_s = std::min(slam.update_time_s, 1.0);
  } else {
    slam.update_travel_m = o.reckoning.odometry_update_travel_m;
    slam.update_turn = o.reckoning.odometry_update_turn;
    slam.match_skipped = true;
  }
  return slam;
}

class RadarSlamStream::Impl {
 public:
  Impl(RadarSlam slam, const RadarSlamStreamOptions& options)
      : options_(options),
        slam_(std::move(slam)),
        synchroniser_(options.sync),
        reckoner_(options.reckoning, options.sync.wheel_base_m) {}

  void add(const WheelSample& sample) {
    if (by_wheels()) synchroniser_.push(sample);
  }
  void add(const GyroSample& sample) {
    if (by_wheels()) synchroniser_.push(sample);
  }
  void add(const OdometrySample& sample) {
    if (accept(kOdometrySamples, sample.time)) odometry_.push(sample);
  }
  void add(const RadarScan& scan) {
    if (by_wheels()) {
      synchroniser_.push(scan);
    } else if (accept(kRadarFrames, scan.time)) {
      radar_.push(scan);
    }
  }

  void add(const LaserScan& scan) {
    if (by_wheels()) {
      synchroniser_.push(scan);
    } else if (accept(kLaserScans, scan.time)) {
      lasers_.push(scan);
    }
  }

  void finish() {
    finished_ = true;
    if (by_wheels()) synchroniser_.finish();
  }

  std::optional<LogTime> step() { return by_wheels() ? step_by_wheels() : step_by_poses(); }
  [[nodiscard]] std::string_view waits_for() const { return waits_for_; }
  void join_pieces() { slam_.finish(); }
  [[nodiscard]] const RadarSlam& slam() const { return slam_; }
  [[nodiscard]] RadarSlamRun result() const {
    RadarSlamRun run;
    run.trajectory = slam_.trajectory();
    RbpfMaps maps = slam_.all_maps();
    run.lidar_map = std::move(maps.lidar);
    run.radar_map = std::move(maps.radar);
    run.statistics = slam_.statistics();
    if (run.statistics.pieces > 1) run.crossings = slam_.wall_crossings();
    run.faults = faults_.faults(Duration(500'000'000));
    run.gyro_bias_rad_s = maps.gyro_bias.mean_rad_s;
    const std::size_t late = late_ + synchroniser_.statistics().refused_late;
    run.refused_scans = refusals_.count + late;
    run.first_refusal =
        late > 0 ? std::to_string(late) + " measurements late or duplicated" : refusals_.first;
    for (const auto& particle : slam_.particles())
      run.particles.push_back({run.trajectory.back().time, MapPose(particle.pose)});
    if (options_.slam.keep_paths)
      for (std::size_t i = 0; i < run.particles.size(); ++i)
        run.paths.push_back(slam_.trajectory(i));
    run.covariance = slam_.covariance();
    run.log_weights.assign(slam_.log_weights().begin(), slam_.log_weights().end());
    return run;
  }

 private:
  [[nodiscard]] bool by_wheels() const { return options_.motion == MotionSource::wheels; }
  [[nodiscard]] bool uses(Stream stream) const {
    if (stream == kOdometrySamples) return options_.motion == MotionSource::odometry;
    return options_.sensors != (stream == kRadarFrames ? SlamSensors::lidar : SlamSensors::radar);
  }

  bool accept(Stream stream, LogTime time) {
    if (!uses(stream)) return false;
    if ((stream_time_[stream] && time <= *stream_time_[stream]) || (last_ && time < *last_)) {
      ++late_;
      return false;
    }
    stream_time_[stream] = time;
    now_ = now_ ? std::max(*now_, time) : time;
    finished_ = false;
    return true;
  }

  /// Whether the stream has reached `time`, or is not waited for any longer.
  [[nodiscard]] bool has_reached(Stream stream, LogTime time) const {
    return !uses(stream) || finished_ || (stream_time_[stream] && *stream_time_[stream] >= time) ||
           *now_ >= time + options_.sync.max_wait;
  }

  /// With wheels and gyro, on the common time base (steps 1 and 2).
  std::optional<LogTime> step_by_wheels() {
    const std::optional<SyncedStep> step = synchroniser_.next();
    if (!step) return std::nullopt;
    const BiasedMotion motion = reckoner_.increment(*step, faults_);
    (void)slam_.move(motion.raw, motion.gyro_s);
    if (step->laser) (void)lidar_scan(*step->laser);
    if (step->radar) (void)radar_scan(step->radar->time, step->radar->points);
    return done(step->time);
  }

  /// With odometry poses at the scans' times; without any, the pose is predicted to stay.
  std::optional<LogTime> step_by_poses() {
    const auto [frames, whole] = group();
    if (lasers_.empty() && !whole) return wait_for({});
    if (!lasers_.empty()) {
      const LogTime time = lasers_.front().time;
      if (frames.empty() ? has_reached(kRadarFrames, time) : frames.back().time >= time)
        return has_reached(kOdometrySamples, time) ? std::optional(process_laser())
                                                   : wait_for("odometry");
      if (!whole) return wait_for("radar scans");
    }
    const LogTime time = frames.back().time;
    if (lasers_.empty() && !has_reached(kLaserScans, time)) return wait_for("laser scans");
    return has_reached(kOdometrySamples, time) ? std::optional(process_radar(frames))
                                               : wait_for("odometry");
  }

  /// Radar frames of the next augmented scan; more may follow if it is not `whole`.
  struct Group {
    std::span<const RadarScan> frames;
    bool whole = false;
  };
  [[nodiscard]] Group group() const {
    const GatherOptions options{.frames = options_.sync.scans};
    const auto frames = radar_.span();
    const std::size_t n = frames_of_one_scan(frames, options);
    if (n == 0) return {};
    const bool silent =
        *now_ > frames.front().time + from_seconds(options.longest_s) + options_.sync.max_wait;
    return {frames.first(n), n == options.frames || n < frames.size() || finished_ || silent};
  }

  LogTime process_radar(std::span<const RadarScan> frames) {
    const GatheredRadar scan = gather(frames, options_.sync.T_base_radar, options_.sync.array,
                                      OdometryTrack(odometry_.span()), options_.sync.moving_m_s);
    radar_.pop(frames.size());
    move_to(scan.time, "motion to radar");
    (void)radar_scan(scan.time, scan.points);
    return done(scan.time);
  }

  LogTime process_laser() {
    const LaserScan scan = lasers_.front();
    lasers_.pop(1);
    move_to(scan.time, "motion to LiDAR");
    (void)lidar_scan(scan);
    return done(scan.time);
  }

  void move_to(LogTime time, const char* sensor) {
    constexpr MotionNoise kNoOdometry{0.15, 0.0, 0.0, Angle::degrees(8.0), 0.0, 0.0};
    const auto samples = odometry_.span();
    const std::optional<SE2d> now = detail::raw(OdometryTrack(samples).at(time));
    if (std::exchange(begun_, true))
      refuse_if_failed(slam_.move(now && T_odom_last_ ? with_noise(T_odom_last_->inverse() * *now,
                                                                   options_.reckoning.odometry)
                                                      : with_noise(SE2d(), kNoOdometry)),
                       sensor, time);
    T_odom_last_ = now;
    last_ = time;
    // Queued radar frames are no older than this.
    const LogTime needed =
        std::min(time, radar_.empty() ? time : radar_.front().time) - from_seconds(1.0);
    const auto first = std::partition_point(samples.begin(), samples.end(),
                                            [&](const auto& s) { return s.time <= needed; });
    if (first - samples.begin() > 1)
      odometry_.pop(static_cast<std::size_t>(first - samples.begin()) - 1);
  }

  std::nullopt_t wait_for(std::string_view what) {
    waits_for_ = what;
    return std::nullopt;
  }

  RbpfOutcome lidar_scan(const LaserScan& scan) {
    if (!uses(kLaserScans)) return {};
    bool returned = false;
    for (std::size_t i = 0; i < scan.ranges_m.size() && !returned; ++i) returned = scan.returned(i);
    if (returned) returned_ = scan.time;
    return record(slam_.add_lidar(scan), "LiDAR", scan.time);
  }

  RbpfOutcome radar_scan(LogTime time, const PointSet& points) {
    if (!uses(kRadarFrames)) return {};
    if (!points.empty()) detected_ = time;
    return record(slam_.add_radar(time, points), "radar", time);
  }
  template <class T>
  void refuse_if_failed(const Result<T>& outcome, const char* sensor, LogTime time) {
    refusals_.add(outcome,
                  std::string(sensor) + " scan at " + std::to_string(time.seconds()) + " s");
  }
  RbpfOutcome record(const Result<RbpfOutcome>& outcome, const char* sensor, LogTime time) {
    refuse_if_failed(outcome, sensor, time);
    return outcome ? *outcome : RbpfOutcome{};
  }
  void report_silence(const char* what, const std::optional<LogTime>& last, LogTime now) {
    constexpr double kLongest_s = 3.0;
    if (last) faults_.set(what, to_seconds(now - *last) > kLongest_s, now);
  }
  LogTime done(LogTime time) {
    report_silence("no LiDAR returns", returned_, time);
    report_silence("no radar points", detected_, time);
    waits_for_ = {};
    return time;
  }

  RadarSlamStreamOptions options_;
  RadarSlam slam_;
  RobotSynchroniser synchroniser_;
  DeadReckoner reckoner_;
  Pending<OdometrySample> odometry_;
  Pending<RadarScan> radar_;
  Pending<LaserScan> lasers_;
  std::array<std::optional<LogTime>, kStreams> stream_time_{};  // latest time of each stream
  std::optional<LogTime> now_, last_;  // latest time of all; of those processed
  std::optional<SE2d> T_odom_last_;
  bool finished_ = false, begun_ = false;
  std::string_view waits_for_;
  std::size_t late_ = 0;
  FaultLog faults_;
  detail::Refusals refusals_;
  std::optional<LogTime> returned_, detected_;  // last time of LiDAR returns, of radar points
};

RadarSlamStream::RadarSlamStream(const RadarSlamStreamOptions& options)
    : RadarSlamStream(RadarSlam(filter_options(options)), options) {}
RadarSlamStream::RadarSlamStream(RadarSlam slam, const RadarSlamStreamOptions& options)
    : impl_(detail::make_owned<Impl>(std::move(slam), options)) {}

void RadarSlamStream::add(const WheelSample& sample) { impl_->add(sample); }
void RadarSlamStream::add(const GyroSample& sample) { impl_->add(sample); }
void RadarSlamStream::add(const OdometrySample& sample) { impl_->add(sample); }
void RadarSlamStream::add(const RadarScan& scan) { impl_->add(scan); }
void RadarSlamStream::add(const LaserScan& scan) { impl_->add(scan); }
void RadarSlamStream::finish() { impl_->finish(); }
std::optional<LogTime> RadarSlamStream::step() { return impl_->step(); }
std::string_view RadarSlamStream::waits_for() const { return impl_->waits_for(); }
void RadarSlamStream::join_pieces() { impl_->join_pieces(); }
const RadarSlam& RadarSlamStream::slam() const { return impl_->slam(); }
const OccupancyGrid& RadarSlamStream::map() const {
  return slam().lidar_map().bounds() ? slam().lidar_map() : slam().radar_map();
}
RadarSlamRun RadarSlamStream::result() const { return impl_->result(); }

}  // namespace wayfare
