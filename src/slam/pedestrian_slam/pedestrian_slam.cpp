#include <wayfare/slam/pedestrian_slam.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <utility>

#include <wayfare/pedestrian/pedestrian.hpp>

namespace wayfare {
namespace {

/// Steps as a way over time: between them at an even pace, after the last for a while as before.
class StepWay {
 public:
  /// A step's vector, in axes that turn with the unit's heading.
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
    if (after == feet_.end()) return beyond(time);
    return between(*(after - 1), *after, time);
  }
  /// Whether somebody walked until just now, as far as is known.
  [[nodiscard]] bool walks(LogTime time) const {
    return !feet_.empty() && to_seconds(time - feet_.back().time) < kGoesOn_s;
  }

 private:
  static constexpr double kGoesOn_s = 1.2;  // steps become known late
  struct Foot {
    LogTime time;
    Eigen::Vector2d position_m;
  };

  static Eigen::Vector2d between(const Foot& a, const Foot& b, LogTime time) {
    const double u = to_seconds(time - a.time) / to_seconds(b.time - a.time);
    return a.position_m + u * (b.position_m - a.position_m);
  }
  [[nodiscard]] Eigen::Vector2d beyond(LogTime time) const {
    const Foot& last = feet_.back();
    if (feet_.size() < 2) return last.position_m;
    const LogTime most = last.time + from_seconds(kGoesOn_s);
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
      way_.add(p.time, p.step.interval_s,
               p.length_m *
                   Eigen::Vector2d(std::cos(p.heading.radians()), std::sin(p.heading.radians())));
    });
    if (status.gyro == UpdateStatus::used) reading_ = sample.time;
    take_heading();
    return status;
  }

  Result<ScanOutcome> add_scan(const LaserScan& scan) {
    levelled_ = level_scan(scan, q_level_laser(), options_.level);
    const SE2d walker = walker_;
    const MotionHint hint = hint_at(scan.time);
    auto outcome = slam_.add_scan(levelled_, hint);
    if (!outcome) {
      walker_ = walker;  // the way there is gone once, with the next scan that is taken
      return outcome;
    }
    dead_reckoning_.push_back({scan.time, Transform2<frame::Map, frame::Base>(walker_)});
    if (options_.feedback) tell_heading(scan.time);
    before_.reset();
    if (hears_unit(scan.time))
      before_ = Before{scan.time, heading_at(scan.time), turned_at(scan.time)};
    if (options_.feedback && options_.steps && before_) tell_steps(scan.time);
    return outcome;
  }

  [[nodiscard]] const Trajectory& dead_reckoning() const { return dead_reckoning_; }
  [[nodiscard]] const WalkFeedback& feedback() const { return feedback_; }
  [[nodiscard]] const Pedestrian& pedestrian() const { return pedestrian_; }
  [[nodiscard]] const LaserScan& levelled() const { return levelled_; }
  [[nodiscard]] SubmapSlam& slam() { return slam_; }

 private:
  static constexpr double kHistory_s = 1.0;  // how late a scan may be placed
  static constexpr double kSilence_s = 0.3;  // after which the unit tells nothing of a scan
  struct Before {
    LogTime time;
    double heading;
    HeadingTrack::Sum turned;
  };

  /// Where the map tells the heading no magnetometer is to: it knows north, and the map does not.
  static PedestrianParameters pedestrian_parameters(const PedestrianSlamOptions& o) {
    PedestrianParameters p = o.pedestrian;
    p.ahrs.heading_history_s = kHistory_s;
    if (!o.feedback || !o.heading) return p;
    p.ahrs.use_magnetometer = false;
    p.magnetic_drift.offset_sigma_uT = 0.0;
    return p;
  }

  [[nodiscard]] bool hears_unit(LogTime time) const {
    return reading_ && to_seconds(time - *reading_) <= kSilence_s;
  }
  [[nodiscard]] HeadingTrack::Sum turned_at(LogTime time) const {
    const HeadingTrack& track = pedestrian_.ahrs().heading_track();
    return track.at(time).value_or(track.now());
  }
  [[nodiscard]] double turn_since(const HeadingTrack::Sum& then, LogTime time) const {
    return (turned_at(time) - then).rotation(pedestrian_.ahrs().gyro_bias_radps());
  }
  /// By what is known now.
  [[nodiscard]] double heading_at(LogTime time) const {
    return heading_ + turn_since(pedestrian_.ahrs().heading_track().now(), time);
  }

  /// The map's heading, which turns with no gyro, to the filter that expected it.
  void tell_heading(LogTime time) {
    const LocalPlacement& local = slam_.local();
    if (!options_.heading || !local.matched) return;
    const double prior = local.expected_sigma[2];
    const auto variance =
        map_heading_.independent_variance(time, local.covariance(2, 2), prior * prior);
    if (!variance) return;
    pedestrian_.add_heading(time, local.T_local_base.raw().heading(), *variance);
    take_heading();
  }

  /// The steps' axes turn with the unit's heading, the map's by what heading it found.
  void tell_steps(LogTime time) {
    const LocalPlacement& local = slam_.local();
    const SE2d& T = local.T_local_base.raw();
    const SO2d to_map = T.rotation() * SO2d(Angle::radians(before_->heading)).inverse();
    by_steps_ += to_map * increment_;
    if (local.matched) feedback_.add(time, T.translation(), by_steps_, local.openness == 0.0);
  }

  void take_heading() {
    if (!pedestrian_.ahrs().ready()) return;
    const Eigen::Vector3d axis = pedestrian_.ahrs().q_world_body() * options_.pedestrian.forward;
    heading_ = std::atan2(axis.y(), axis.x());
  }

  /// From the laser to level axes whose x is the unit's forward axis, levelled.
  [[nodiscard]] SO3d q_level_laser() const {
    if (!pedestrian_.ahrs().ready()) return options_.q_unit_laser;
    return SO3d::exp(Eigen::Vector3d(0, 0, -heading_)) * pedestrian_.ahrs().q_world_body() *
           options_.q_unit_laser;
  }

  /// What is known of the motion since the scan before; moves the walker along it.
  MotionHint hint_at(LogTime time) {
    increment_.setZero();
    const std::uint64_t restarts = pedestrian_.report().ahrs.restarts;
    if (!hears_unit(time) || std::exchange(restarts_, restarts) != restarts) before_.reset();
    if (!pedestrian_.ahrs().ready() || !before_) return {};
    const Angle turn = Angle::radians(turn_since(before_->turned, time));
    const bool rests = pedestrian_.ahrs().at_rest();
    const bool steps_tell = options_.steps && (rests || way_.walks(time));
    if (steps_tell) increment_ = way_.at(time) - way_.at(before_->time);
    const SO2d level = SO2d(Angle::radians(before_->heading)).inverse();
    const Eigen::Vector2d step = feedback_.scale() * (SO2d(feedback_.direction()) * increment_);
    walker_ = walker_ * SE2d(Eigen::Vector2d(level * step), SO2d(turn));
    if (!steps_tell) return {{}, turn};
    return {Transform2<frame::Odom, frame::Base>(walker_), turn};
  }

  PedestrianSlamOptions options_;
  Pedestrian pedestrian_;
  WalkFeedback feedback_;
  MapHeading map_heading_;
  SubmapSlam slam_;
  StepWay way_;
  double heading_ = 0.0;          // of the unit's forward axis, rad
  std::optional<Before> before_;  // the scan before, where the unit told of it
  std::optional<LogTime> reading_;
  std::uint64_t restarts_ = 0;
  SE2d walker_;
  Eigen::Vector2d increment_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d by_steps_ = Eigen::Vector2d::Zero();  // in the map's axes
  LaserScan levelled_;
  Trajectory dead_reckoning_;
};

PedestrianSlam::PedestrianSlam(const PedestrianSlamOptions& options)
    : engine_(std::make_unique<Engine>(options)) {}
PedestrianSlam::~PedestrianSlam() = default;
PedestrianSlam::PedestrianSlam(PedestrianSlam&&) noexcept = default;
PedestrianSlam& PedestrianSlam::operator=(PedestrianSlam&&) noexcept = default;

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

}  // namespace wayfare
