#include <wayfare/slam/pedestrian_slam.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <utility>

#include <wayfare/core/detail/call_guard.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/sensors/pose_history.hpp>
#include <wayfare/slam/detail/scans.hpp>

namespace wayfare {
namespace {

/// The path by steps: linear in time between steps, extrapolated for a while after the last.
class StepPath {
 public:
  /// A step vector, in axes that rotate with the unit's heading.
  void add(LogTime time, double interval_s, const Eigen::Vector2d& step_m) {
    constexpr std::size_t kKept = 64;
    const LogTime began = time - from_seconds(std::clamp(interval_s, 0.2, 1.5));
    if (feet_.empty() || feet_.back().time < began)
      feet_.push_back({began, feet_.empty() ? Eigen::Vector2d::Zero() : feet_.back().position_m});
    if (!(feet_.back().time < time)) return;
    feet_.push_back({time, feet_.back().position_m + step_m});
    while (feet_.size() > kKept) feet_.pop_front();
  }

  [[nodiscard]] Eigen::Vector2d at(LogTime time) const {
    if (feet_.empty()) return Eigen::Vector2d::Zero();
    const auto after =
        std::find_if(feet_.begin(), feet_.end(), [&](const Foot& f) { return f.time >= time; });
    if (after == feet_.begin()) return after->position_m;
    if (after == feet_.end()) return extrapolate(time);
    return between(*(after - 1), *after, time);
  }
  /// Whether the last known step is recent.
  [[nodiscard]] bool is_walking(LogTime time) const {
    return !feet_.empty() && to_seconds(time - feet_.back().time) < kExtrapolate_s;
  }

 private:
  static constexpr double kExtrapolate_s = 1.2;  // a step is detected with this delay
  struct Foot {
    LogTime time;
    Eigen::Vector2d position_m;
  };

  static Eigen::Vector2d between(const Foot& a, const Foot& b, LogTime time) {
    const double u = to_seconds(time - a.time) / to_seconds(b.time - a.time);
    return a.position_m + u * (b.position_m - a.position_m);
  }
  [[nodiscard]] Eigen::Vector2d extrapolate(LogTime time) const {
    const Foot& last = feet_.back();
    if (feet_.size() < 2) return last.position_m;
    const LogTime most = last.time + from_seconds(kExtrapolate_s);
    return between(feet_[feet_.size() - 2], last, std::min(time, most));
  }

  std::deque<Foot> feet_;
};

}  // namespace

class PedestrianSlam::Engine {
 public:
  explicit Engine(const PedestrianSlamOptions& options)
      : options_(options),
        pedestrian_(pedestrian_parameters(options)),
        feedback_(options.walk),
        map_heading_(options.map_heading),
        slam_(options.slam) {}

  MargUpdateStatus add(const MargSample& sample) {
    const MargUpdateStatus status = pedestrian_.add(sample, [&](const PedestrianPose& p) {
      steps_.add(p.time, p.step.interval_s,
                 p.length_m *
                     Eigen::Vector2d(std::cos(p.heading.radians()), std::sin(p.heading.radians())));
    });
    if (status.gyro == UpdateStatus::used) last_sample_ = sample.time;
    read_heading();
    remember_attitude(sample.time);
    return status;
  }

  Result<ScanOutcome> add_scan(const LaserScan& scan) {
    return guard_.run([&] { return add(scan); });
  }
  Result<ScanOutcome> add(const LaserScan& scan) {
    if (auto ok = detail::check_scan(scan, {}, dead_reckoning_); !ok) return ok.error();
    const SE2d walker = walker_;
    const MotionHint hint = hint_at(scan.time);
    if (!scan.is_sweep() || !level_sweep(scan))
      levelled_ = level_scan(scan, q_level_laser(), options_.level);
    auto outcome = slam_.add_scan(levelled_, hint);
    if (!outcome) {
      walker_ = walker;  // the next scan accepted takes this motion as well
      return outcome;
    }
    measure_velocity(scan.time);
    dead_reckoning_.push_back({scan.time, MapPose(walker_)});
    if (options_.feedback) add_map_heading(scan.time);
    previous_.reset();
    if (has_recent_sample(scan.time))
      previous_ = PreviousScan{scan.time, heading_at(scan.time), rotation_at(scan.time)};
    if (options_.feedback && options_.steps && previous_) update_feedback(scan.time);
    return outcome;
  }

  [[nodiscard]] const Trajectory& dead_reckoning() const { return dead_reckoning_; }
  [[nodiscard]] const WalkFeedback& feedback() const { return feedback_; }
  [[nodiscard]] const Pedestrian& pedestrian() const { return pedestrian_; }
  [[nodiscard]] const LaserScan& levelled() const { return levelled_; }
  [[nodiscard]] SubmapSlam& slam() { return slam_; }

 private:
  static constexpr double kHistory_s = 1.0;  // greatest delay of a scan
  static constexpr double kMaxAge_s = 0.3;   // greatest age of the last sample at a scan
  struct PreviousScan {
    LogTime time;
    double heading;
    HeadingTrack::Sum rotation;
  };

  /// With heading from the map no magnetometer is used: it measures north, which the map does not
  /// know.
  static PedestrianParameters pedestrian_parameters(const PedestrianSlamOptions& o) {
    PedestrianParameters p = o.pedestrian;
    p.ahrs.heading_history_s = kHistory_s;
    if (!o.feedback || !o.heading) return p;
    p.ahrs.use_magnetometer = false;
    p.magnetic_drift.offset_sigma_uT = 0.0;
    return p;
  }

  [[nodiscard]] bool has_recent_sample(LogTime time) const {
    return last_sample_ && to_seconds(time - *last_sample_) <= kMaxAge_s;
  }
  [[nodiscard]] HeadingTrack::Sum rotation_at(LogTime time) const {
    const HeadingTrack& track = pedestrian_.ahrs().heading_track();
    return track.at(time).value_or(track.now());
  }
  [[nodiscard]] double rotation_since(const HeadingTrack::Sum& then, LogTime time) const {
    return (rotation_at(time) - then).rotation(pedestrian_.ahrs().gyro_bias_radps());
  }
  /// By the current estimate.
  [[nodiscard]] double heading_at(LogTime time) const {
    return heading_ + rotation_since(pedestrian_.ahrs().heading_track().now(), time);
  }

  /// Between the poses of the last two scans, beside steps averaged over a few.
  void measure_velocity(LogTime time) {
    constexpr double kGain = 0.5;
    const SE2d& T = slam_.local().T_local_base.raw();
    Eigen::Vector2d latest = Eigen::Vector2d::Zero();
    if (!dead_reckoning_.empty() && time > dead_reckoning_.back().time)
      latest = T.rotation().inverse() *
               Eigen::Vector2d(T.translation() - T_local_last_.translation()) /
               to_seconds(time - dead_reckoning_.back().time);
    by_map_mps_ += (by_step_mps_ ? kGain : 1.0) * Eigen::Vector2d(latest - by_map_mps_);
    T_local_last_ = T;
  }

  /// Of the map where the latest match determined it: the direction of steps turns with glances.
  [[nodiscard]] const Eigen::Vector2d& velocity_mps() const {
    const bool by_map = slam_.local().matched && slam_.local().openness == 0.0;
    return by_map || !by_step_mps_ ? by_map_mps_ : *by_step_mps_;
  }

  /// Gives the map's heading, free of gyro drift, to the attitude filter.
  void add_map_heading(LogTime time) {
    const LocalPlacement& local = slam_.local();
    if (!options_.heading || !local.matched) return;
    const double prior = local.predicted_sigma[2];
    const auto variance =
        map_heading_.independent_variance(time, local.covariance(2, 2), prior * prior);
    if (!variance) return;
    pedestrian_.add_heading(time, local.T_local_base.raw().heading(), *variance);
    read_heading();
  }

  /// The step axes rotate with the unit's heading; they are rotated by the heading found in the
  /// map.
  void update_feedback(LogTime time) {
    const LocalPlacement& local = slam_.local();
    const SE2d& T = local.T_local_base.raw();
    const SO2d to_map = T.rotation() * SO2d(Angle::radians(previous_->heading)).inverse();
    by_steps_ += to_map * increment_;
    if (local.matched) feedback_.add(time, T.translation(), by_steps_, local.openness == 0.0);
  }

  void read_heading() {
    if (!pedestrian_.ahrs().ready()) return;
    const Eigen::Vector3d axis = pedestrian_.ahrs().q_world_body() * options_.pedestrian.forward;
    heading_ = std::atan2(axis.y(), axis.x());
  }

  /// From the laser to level axes whose x is the unit's forward axis.
  [[nodiscard]] SO3d q_level_laser() const {
    if (!pedestrian_.ahrs().ready()) return options_.q_unit_laser;
    return SO3d::exp(Eigen::Vector3d(0, 0, -heading_)) * pedestrian_.ahrs().q_world_body() *
           options_.q_unit_laser;
  }

  void remember_attitude(LogTime time) {
    const std::uint64_t restarts = pedestrian_.report().ahrs.restarts;
    if (std::exchange(attitude_restarts_, restarts) != restarts) attitude_.clear();
    if (!pedestrian_.ahrs().ready()) return;
    const SE3d turned(Eigen::Vector3d::Zero(), pedestrian_.ahrs().q_world_body());
    (void)attitude_.add(time, turned);  // where it is later than the last
  }

  /// By the attitude during the sweep. False where it is not known during all of it.
  bool level_sweep(const LaserScan& scan) {
    const SO3d to_heading = SO3d::exp(Eigen::Vector3d(0, 0, -heading_at(scan.time)));
    const Eigen::Vector2d& velocity = velocity_mps();
    const auto laser = [&](LogTime time) -> std::optional<SE3d> {
      const auto unit = attitude_(time);
      if (!unit) return std::nullopt;
      Eigen::Vector3d moved = Eigen::Vector3d::Zero();
      moved.head<2>() = to_seconds(time - scan.time) * velocity;
      return SE3d(moved, to_heading * unit->rotation() * options_.q_unit_laser);
    };
    return level_scan(scan, laser, scan.time, levelled_, options_.level).has_value();
  }

  /// The motion since the previous scan; also updates the dead-reckoned pose.
  MotionHint hint_at(LogTime time) {
    increment_.setZero();
    by_step_mps_.reset();
    const std::uint64_t restarts = pedestrian_.report().ahrs.restarts;
    if (!has_recent_sample(time) || std::exchange(restarts_, restarts) != restarts)
      previous_.reset();
    if (!pedestrian_.ahrs().ready() || !previous_) return {};
    const Angle turn = Angle::radians(rotation_since(previous_->rotation, time));
    const bool at_rest = pedestrian_.ahrs().at_rest();
    const bool steps_known = options_.steps && (at_rest || steps_.is_walking(time));
    if (steps_known) increment_ = steps_.at(time) - steps_.at(previous_->time);
    const SO2d level = SO2d(Angle::radians(previous_->heading)).inverse();
    const Eigen::Vector2d step = feedback_.scale() * (SO2d(feedback_.direction()) * increment_);
    walker_ = walker_ * SE2d(Eigen::Vector2d(level * step), SO2d(turn));
    if (!steps_known) return {{}, turn};
    const double dt = to_seconds(time - previous_->time);
    if (dt > 0.0) by_step_mps_ = SO2d(turn).inverse() * Eigen::Vector2d(level * step) / dt;
    return {OdomPose(walker_), turn};
  }

  detail::CallGuard guard_;
  PedestrianSlamOptions options_;
  Pedestrian pedestrian_;
  WalkFeedback feedback_;
  MapHeading map_heading_;
  SubmapSlam slam_;
  StepPath steps_;
  double heading_ = 0.0;                  // of the unit's forward axis, rad
  std::optional<PreviousScan> previous_;  // the previous scan, if it had recent samples
  std::optional<LogTime> last_sample_;
  std::uint64_t restarts_ = 0;
  SE2d walker_;
  Eigen::Vector2d increment_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d by_steps_ = Eigen::Vector2d::Zero();  // in the map's axes
  PoseHistory<SE3d> attitude_;                          // of the unit, for sweeps
  std::uint64_t attitude_restarts_ = 0;
  SE2d T_local_last_;
  // Of the walker, along levelled axes whose x is the heading.
  std::optional<Eigen::Vector2d> by_step_mps_;
  Eigen::Vector2d by_map_mps_ = Eigen::Vector2d::Zero();
  LaserScan levelled_;
  Trajectory dead_reckoning_;
};

PedestrianSlam::PedestrianSlam(const PedestrianSlamOptions& options)
    : engine_(detail::make_owned<Engine>(options)) {}

MargUpdateStatus PedestrianSlam::add(const MargSample& sample) { return engine_->add(sample); }
Result<ScanOutcome> PedestrianSlam::add_scan(const LaserScan& scan) {
  return engine_->add_scan(scan);
}
const Trajectory& PedestrianSlam::dead_reckoning() const { return engine_->dead_reckoning(); }
const WalkFeedback& PedestrianSlam::feedback() const { return engine_->feedback(); }
const Pedestrian& PedestrianSlam::pedestrian() const { return engine_->pedestrian(); }
const LaserScan& PedestrianSlam::levelled() const { return engine_->levelled(); }
const SubmapSlam& PedestrianSlam::slam() const { return engine_->slam(); }
SubmapSlam& PedestrianSlam::slam() { return engine_->slam(); }

Result<PedestrianSlamRun> run_pedestrian_slam(const Recording& recording, const MargRecording& unit,
                                              PedestrianSlamOptions options,
                                              const SlamProgress& progress) {
  options.slam.T_base_laser = recording.T_base_laser;
  PedestrianSlam walker(options);
  auto reading = unit.begin();
  const SubmapSlamStatistics& statistics = walker.slam().statistics();
  auto refused = detail::feed_scans(recording, progress, statistics, [&](std::size_t i) {
    const LaserScan& scan = recording.scans[i];
    for (; reading != unit.end() && reading->time <= scan.end_time(); ++reading)
      walker.add(*reading);
    return walker.add_scan(scan);
  });
  if (!refused) return refused.error();
  auto slam = detail::finished_run(walker.slam(), *std::move(refused));
  if (!slam) return slam.error();
  return PedestrianSlamRun{*std::move(slam), walker.dead_reckoning(), walker.feedback().scale()};
}

}  // namespace wayfare
