#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/detail/scans.hpp>
#include <wayfare/slam/localisation.hpp>

#include "slam/localisation/motion_guard.hpp"
#include "slam/localisation/pose_filter.hpp"
#include "slam/localisation/scan_weigher.hpp"

namespace wayfare {

/// A second set of particles, drawn globally when the first is unreliable, and its odds.
struct RelocalisationHypothesis {
  PoseFilter filter;
  double log_odds;             // that it is right rather than the first
  bool for_poor_fit = false;   // started because of a poor fit, not for confirmation
  std::array<int, 2> scans{};  // of LiDAR and radar

  /// The larger of the two counts: a second sensor must not shorten the path allowed to a
  /// hypothesis.
  [[nodiscard]] int age() const { return std::max(scans[0], scans[1]); }
};

bool same_place(const SE2d& a, const SE2d& b, const LocalisationOptions& options) {
  return (a.translation() - b.translation()).norm() < options.bin_m &&
         std::abs((a.heading() - b.heading()).wrapped().radians()) < options.bin_turn.radians();
}

/// Recent scans of one sensor and their agreement with the map.
struct SensorHistory {
  SE2d since_weighed;  // motion since the last scan that was weighed
  std::optional<LogTime> weighed_at;
  double recent = 0.0, last = 0.0;  // recent agreement, and that of the last scan
  double usual = 0.0;               // while converged, and since a search that found nothing better
  double best = 0.0;  // while converged: reveals a pose that fits no better than others

  /// After a change of pose. The usual agreement on this map is kept, to detect a wrong pose.
  void reset_recent() { recent = last = 0.0; }
  void remember(double agreement, bool converged, double search_ratio) {
    constexpr double kFast = 0.3, kSlow = 0.02;
    last = agreement;
    recent += (recent == 0.0 ? 1.0 : kFast) * (agreement - recent);
    if (!converged) return;
    // Slower still at a poor fit, or the usual agreement would follow a kidnapped robot.
    const auto follow = [&](double& value) {
      const double rate = recent < search_ratio * value ? 0.1 * kSlow : kSlow;
      value += (value == 0.0 ? 1.0 : rate) * (agreement - value);
    };
    follow(usual);
    follow(best);
  }

  [[nodiscard]] bool is_due(LogTime time, const LocalisationOptions& options) const {
    return !weighed_at || reaches(since_weighed, options.update_travel_m, options.update_turn) ||
           to_seconds(time - *weighed_at) >= options.update_time_s;
  }
  [[nodiscard]] bool fits_worse_than(double agreement) const {
    return recent > 0.0 && recent < agreement;
  }
};

class Localiser::Engine {
 public:
  Engine(std::shared_ptr<const LocalisationMap> map, const LocalisationOptions& options,
         std::uint64_t seed)
      : map_(std::move(map)), options_(options), rng_(seed) {
    WAYFARE_EXPECTS(map_ != nullptr, "a localiser needs a map");
  }

  Result<void> start_at(const Gaussian<SE2d>& pose) {
    if (!detail::finite(pose.mean) || !is_positive_semidefinite(pose.covariance))
      return Error{ErrorCode::invalid,
                   "start_at: the pose is not finite or its covariance not positive semi-definite"};
    start_anywhere();
    filter_ = new_filter();
    filter_->start_at(pose);
    pose_given_ = true;
    return {};
  }

  void start_anywhere() {
    filter_.reset();
    relocalisation_.reset();
    histories_ = {};
    confirmed_ = pose_given_ = false;
    since_search_ = 0;
  }

  Result<void> add_motion(LogTime time, const std::optional<SE2d>& odometry) {
    if (motion_.time() && time <= *motion_.time())
      return Error{ErrorCode::invalid, "a motion not later than the last"};
    move_to(time, odometry);
    return {};
  }

  Result<LocalisationOutcome> add_scan(const LaserScan& scan, const std::optional<SE2d>& odometry) {
    if (!detail::has_finite_bearings(scan))
      return Error{ErrorCode::invalid, "a scan whose bearings are not finite"};
    if (motion_.time() && scan.time <= *motion_.time())
      return Error{ErrorCode::invalid, "a scan not later than the last: late or duplicated"};
    return add(scan.time, ScanWeigher(scan, options_), odometry);
  }

  Result<LocalisationOutcome> add_radar(LogTime time, const PointSet& points,
                                        const std::optional<SE2d>& odometry) {
    if (!map_->has(RangeSensor::radar))
      return Error{ErrorCode::invalid, "the map has no radar detections"};
    if (motion_.time() && time < *motion_.time())
      return Error{ErrorCode::invalid, "a radar scan earlier than the last scan"};
    for (std::size_t i = 0; i < points.size(); ++i)
      if (!points[i].allFinite())
        return Error{ErrorCode::invalid, "a radar scan whose points are not finite"};
    return add(time, ScanWeigher(points, options_), odometry);
  }

  [[nodiscard]] const ParticleSet& particles() const {
    static const ParticleSet none;
    return filter_ ? filter_->particles() : none;
  }

 private:
  /// Returns true if odometry could not be used.
  bool move_to(LogTime time, const std::optional<SE2d>& odometry) {
    const bool first = !motion_.time();
    const MotionGuard::Step step = motion_.step(time, odometry);
    if (first) return step.refused;
    if (filter_) filter_->move(step.motion);
    if (relocalisation_) relocalisation_->filter.move(step.motion);
    for (SensorHistory& h : histories_) h.since_weighed = h.since_weighed * step.motion.mean;
    return step.refused;
  }

  LocalisationOutcome add(LogTime time, const ScanWeigher& scan,
                          const std::optional<SE2d>& odometry) {
    LocalisationOutcome outcome;
    outcome.time = time;
    outcome.sensor = scan.sensor();
    if (!motion_.time() || time > *motion_.time())
      outcome.odometry_refused = move_to(time, odometry);
    outcome.weighed = scan.enough() && history_of(scan).is_due(time, options_);
    if (outcome.weighed) apply(scan, outcome);
    outcome.T_map_base.covariance = Eigen::Matrix3d::Constant(INFINITY);
    if (!filter_) return outcome;
    const PoseEstimate& estimate = filter_->update_estimate();
    motion_.update(estimate.pose.mean);
    outcome.T_map_base = estimate.pose;
    outcome.mass = estimate.mass;
    outcome.clusters = estimate.clusters;
    outcome.particles = filter_->particles().size();
    if (outcome.weighed) {
      outcome.agreement = scan.agreement(*map_, estimate.pose.mean);
      history_of(scan).remember(outcome.agreement, estimate.converged, options_.search_ratio);
    }
    outcome.converged = estimate.converged && !agreement_is_poor();
    return outcome;
  }

  void apply(const ScanWeigher& scan, LocalisationOutcome& outcome) {
    SensorHistory& history = history_of(scan);
    history.weighed_at = outcome.time;
    history.since_weighed = SE2d();
    ++since_search_;
    if (!filter_) {
      filter_ = new_filter();
      filter_->start_anywhere(scan);
      since_search_ = 0;
      outcome.searched = true;
      return;
    }
    // A confirmation search started earlier has odds biased by the time before: start a new one.
    if (relocalisation_ && !relocalisation_->for_poor_fit && filter_->estimate().converged &&
        fit_is_poor())
      relocalisation_.reset();
    if (relocalisation_ || search_is_due()) {
      outcome.searched = !relocalisation_;
      update_hypothesis(scan);
    }
    if (filter_->estimate().converged && history.last < options_.search_ratio * history.usual)
      filter_->add_noisy_copies();
    filter_->weigh(scan);
    filter_->resample_if_due();
    if (relocalisation_) resolve_hypothesis(outcome);
  }

  /// Odds that the robot was kidnapped: the prior, times each scan's evidence for poses anywhere
  /// over its evidence for the current particles, each weighted by the scans before.
  void update_hypothesis(const ScanWeigher& scan) {
    if (!relocalisation_) {
      const double prior = options_.kidnap_probability;
      relocalisation_ =
          RelocalisationHypothesis{new_filter(), std::log(prior / (1.0 - prior)), fit_is_poor()};
      relocalisation_->log_odds =
          log_odds_after(relocalisation_->log_odds, relocalisation_->filter.start_anywhere(scan),
                         filter_->log_evidence(scan, true));
    } else {
      PoseFilter& other = relocalisation_->filter;
      const bool broad = !other.estimate().converged || !filter_->estimate().converged;
      relocalisation_->log_odds =
          log_odds_after(relocalisation_->log_odds, other.log_evidence(scan, broad),
                         filter_->log_evidence(scan, broad));
      other.weigh(scan);
      other.resample_if_due();
    }
    relocalisation_->filter.update_estimate();
    ++relocalisation_->scans[static_cast<std::size_t>(scan.sensor())];
  }

  void resolve_hypothesis(LocalisationOutcome& outcome) {
    constexpr double kDecisive = 8.0;              // nats: odds of 3000 to 1
    constexpr int kPatience = 30, kLongest = 100;  // scans: without promising odds, and in total
    const PoseEstimate& other = relocalisation_->filter.estimate();
    const PoseEstimate& current = filter_->update_estimate();
    const bool same = other.converged && same_place(other.pose.mean, current.pose.mean, options_);
    if (relocalisation_->log_odds > kDecisive && !same) {
      filter_ = std::move(relocalisation_->filter);
      outcome.relocalised = true;
      for (SensorHistory& h : histories_) h.reset_recent();
      confirmed_ = pose_given_ = false;
    } else if (same && current.converged) {
      confirmed_ = true;
      for (SensorHistory& h : histories_) h.usual = h.recent;  // no pose fits better
    } else if (relocalisation_->age() < (relocalisation_->log_odds < 0.0 ? kPatience : kLongest)) {
      return;
    } else if (pose_given_) {
      confirmed_ = true;
    }
    relocalisation_.reset();
    since_search_ = 0;
  }

  /// At a poor fit, or when the pose was given or found by a single global search and is
  /// unconfirmed.
  [[nodiscard]] bool search_is_due() const {
    const int wait = std::max(options_.scans_between_searches, 1);
    const PoseEstimate& estimate = filter_->estimate();
    if (estimate.converged && fit_is_poor()) return since_search_ >= wait;
    return (!estimate.converged || !confirmed_) && since_search_ / 4 >= wait;
  }

  [[nodiscard]] bool fit_is_poor() const {
    return std::any_of(histories_.begin(), histories_.end(), [&](const SensorHistory& h) {
      return h.fits_worse_than(options_.search_ratio * h.usual);
    });
  }
  [[nodiscard]] bool agreement_is_poor() const {
    return std::any_of(histories_.begin(), histories_.end(), [&](const SensorHistory& h) {
      return h.fits_worse_than(options_.rejection_ratio * h.best);
    });
  }
  [[nodiscard]] SensorHistory& history_of(const ScanWeigher& scan) {
    return histories_[static_cast<std::size_t>(scan.sensor())];
  }
  [[nodiscard]] PoseFilter new_filter() { return {map_, options_, rng_.stream(filters_++)}; }

  std::shared_ptr<const LocalisationMap> map_;
  LocalisationOptions options_;
  Rng rng_;
  std::uint64_t filters_ = 0;
  MotionGuard motion_{options_};
  std::optional<PoseFilter> filter_;  // none where nothing is known
  std::optional<RelocalisationHypothesis> relocalisation_;
  std::array<SensorHistory, 2> histories_;  // of LiDAR and radar
  bool confirmed_ = false;                  // a global search found the same pose
  bool pose_given_ = false;  // the pose was given: one search without a better result confirms it
  int since_search_ = 0;     // scans weighted
};

Localiser::Localiser(std::shared_ptr<const LocalisationMap> map, const LocalisationOptions& options,
                     std::uint64_t seed)
    : engine_(detail::make_owned<Engine>(std::move(map), options, seed)) {}

Result<void> Localiser::start_at(const Gaussian<SE2d>& T_map_base) {
  return engine_->start_at(T_map_base);
}
void Localiser::start_anywhere() { engine_->start_anywhere(); }

Result<void> Localiser::add_motion(LogTime time, const std::optional<OdomPose>& odometry) {
  return engine_->add_motion(time, detail::raw(odometry));
}

Result<LocalisationOutcome> Localiser::add_scan(const LaserScan& scan,
                                                const std::optional<OdomPose>& odometry) {
  return engine_->add_scan(scan, detail::raw(odometry));
}

Result<LocalisationOutcome> Localiser::add_radar(LogTime time, const PointSet& points_base,
                                                 const std::optional<OdomPose>& odometry) {
  return engine_->add_radar(time, points_base, detail::raw(odometry));
}

std::vector<PoseParticle> Localiser::particles() const {
  const ParticleSet& set = engine_->particles();
  const std::vector<double> weights = weights_of(set);
  std::vector<PoseParticle> result;
  result.reserve(set.size());
  for (std::size_t i = 0; i < set.size(); ++i) result.push_back({set.pose(i), weights[i]});
  return result;
}

}  // namespace wayfare
