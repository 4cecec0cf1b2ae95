#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include <wayfare/filter/particles.hpp>
#include <wayfare/slam/localisation.hpp>

#include "slam/localisation/motion_guard.hpp"
#include "slam/localisation/pose_filter.hpp"
#include "slam/localisation/scan_weigher.hpp"

namespace wayfare {
namespace {

std::optional<SE2d> raw(const std::optional<Transform2<frame::Odom, frame::Base>>& odometry) {
  return odometry ? std::optional(odometry->raw()) : std::nullopt;
}

Result<void> check(const LaserScan& scan) {
  if (!std::isfinite(scan.first_bearing.radians()) || !std::isfinite(scan.bearing_step.radians()))
    return Error{ErrorCode::invalid, "a scan whose bearings are not finite"};
  return {};
}

}  // namespace

/// A second set of particles, begun from nowhere where the first is in doubt, and the odds of it.
struct RelocalisationHypothesis {
  PoseFilter filter;
  double log_odds;             // that it, and not the first, is right
  bool in_doubt = false;       // begun because scans fit badly, not to make sure
  std::array<int, 2> scans{};  // of lidar and radar

  /// Of the sensor that had most: a second sensor must not shorten the way both are given.
  [[nodiscard]] int age() const { return std::max(scans[0], scans[1]); }
};

bool same_place(const SE2d& a, const SE2d& b, const LocalisationOptions& options) {
  return (a.translation() - b.translation()).norm() < options.bin_m &&
         std::abs((a.heading() - b.heading()).wrapped().radians()) < options.bin_turn.radians();
}

/// What a sensor saw last, and how well it used to agree with the map.
struct SensorMemory {
  SE2d since_weighed;  // motion since the last scan that was weighed
  std::optional<LogTime> weighed_at;
  double recent = 0.0, last = 0.0;  // agreement of late, and of the last scan
  double usual = 0.0;               // while converged, and since a search that found no better
  double best = 0.0;  // while converged: what a place that fits no better than others is known by

  /// Elsewhere: what is usual on this map stays, for a wrong place to be known by.
  void begin_anew() { recent = last = 0.0; }
  void remember(double agreement, bool converged, double suspicion);
  [[nodiscard]] bool says_something_new(LogTime time, const LocalisationOptions& options) const;
  [[nodiscard]] bool fits_worse_than_usual(double share) const {
    return recent > 0.0 && recent < share * usual;
  }
  [[nodiscard]] bool fits_worse_than_best(double share) const {
    return recent > 0.0 && recent < share * best;
  }
};

void SensorMemory::remember(double agreement, bool converged, double suspicion) {
  constexpr double kFast = 0.3, kSlow = 0.02;
  last = agreement;
  recent += (recent == 0.0 ? 1.0 : kFast) * (agreement - recent);
  if (!converged) return;
  // Slower still while in doubt, or what was usual would follow the robot that was carried away.
  const auto follow = [&](double& value) {
    const double rate = recent < suspicion * value ? 0.1 * kSlow : kSlow;
    value += (value == 0.0 ? 1.0 : rate) * (agreement - value);
  };
  follow(usual);
  follow(best);
}

bool SensorMemory::says_something_new(LogTime time, const LocalisationOptions& options) const {
  return !weighed_at || since_weighed.translation().norm() >= options.between_m ||
         std::abs(since_weighed.heading().radians()) >= options.between_turn.radians() ||
         to_seconds(time - *weighed_at) >= options.between_s;
}

class Localiser::Engine {
 public:
  Engine(std::shared_ptr<const LocalisationMap> map, const LocalisationOptions& options,
         std::uint64_t seed)
      : map_(std::move(map)), options_(options), rng_(seed) {}

  Result<void> start_at(const Gaussian<SE2d>& pose);
  void start_anywhere();
  Result<void> add_motion(LogTime time, const std::optional<SE2d>& odometry);
  Result<LocalisationOutcome> add_scan(const LaserScan& scan, const std::optional<SE2d>& odometry);
  Result<LocalisationOutcome> add_radar(LogTime time, const PointSet& points,
                                        const std::optional<SE2d>& odometry);

  [[nodiscard]] const ParticleSet& particles() const {
    static const ParticleSet none;
    return filter_ ? filter_->particles() : none;
  }

 private:
  bool move_to(LogTime time, const std::optional<SE2d>& odometry);
  LocalisationOutcome add(LogTime time, const ScanWeigher& scan,
                          const std::optional<SE2d>& odometry);
  void take(const ScanWeigher& scan, LocalisationOutcome& outcome);
  void challenge(const ScanWeigher& scan);
  void settle(LocalisationOutcome& outcome);
  [[nodiscard]] bool in_doubt() const;
  [[nodiscard]] bool fits_badly() const {
    return std::any_of(memories_.begin(), memories_.end(), [&](const SensorMemory& m) {
      return m.fits_worse_than_usual(options_.suspicion);
    });
  }
  [[nodiscard]] bool unbelievable() const {
    return std::any_of(memories_.begin(), memories_.end(), [&](const SensorMemory& m) {
      return m.fits_worse_than_best(options_.disbelief);
    });
  }
  [[nodiscard]] SensorMemory& memory_of(const ScanWeigher& scan) {
    return memories_[static_cast<std::size_t>(scan.sensor())];
  }
  [[nodiscard]] PoseFilter new_filter() { return {map_, options_, rng_.stream(filters_++)}; }

  std::shared_ptr<const LocalisationMap> map_;
  LocalisationOptions options_;
  Rng rng_;
  std::uint64_t filters_ = 0;
  MotionGuard motion_{options_};
  std::optional<PoseFilter> filter_;  // none where nothing is known
  std::optional<RelocalisationHypothesis> relocalisation_;
  std::array<SensorMemory, 2> memories_;  // of lidar and radar
  bool confirmed_ = false;                // a search from nowhere came to the same pose
  bool given_ = false;    // the pose was told: one search that finds no better is enough
  int since_search_ = 0;  // scans weighed
};

Result<void> Localiser::Engine::start_at(const Gaussian<SE2d>& pose) {
  const Eigen::LDLT<Eigen::Matrix3d> ldlt(pose.covariance);
  if (!pose.mean.translation().allFinite() || !std::isfinite(pose.mean.heading().radians()) ||
      !pose.covariance.allFinite() || ldlt.info() != Eigen::Success || !ldlt.isPositive())
    return Error{ErrorCode::invalid,
                 "start_at: the pose is not finite or its covariance not positive semi-definite"};
  start_anywhere();
  filter_ = new_filter();
  filter_->start_at(pose);
  given_ = true;
  return {};
}

void Localiser::Engine::start_anywhere() {
  filter_.reset();
  relocalisation_.reset();
  memories_ = {};
  confirmed_ = given_ = false;
  since_search_ = 0;
}

// True where odometry could not be used.
bool Localiser::Engine::move_to(LogTime time, const std::optional<SE2d>& odometry) {
  const bool first = !motion_.time();
  const MotionGuard::Step step = motion_.step(time, odometry);
  if (first) return step.refused;
  if (filter_) filter_->move(step.motion);
  if (relocalisation_) relocalisation_->filter.move(step.motion);
  for (SensorMemory& m : memories_) m.since_weighed = m.since_weighed * step.motion.mean;
  return step.refused;
}

Result<void> Localiser::Engine::add_motion(LogTime time, const std::optional<SE2d>& odometry) {
  if (motion_.time() && time <= *motion_.time())
    return Error{ErrorCode::invalid, "a motion not later than the last"};
  move_to(time, odometry);
  return {};
}

Result<LocalisationOutcome> Localiser::Engine::add_scan(const LaserScan& scan,
                                                        const std::optional<SE2d>& odometry) {
  if (auto ok = check(scan); !ok) return ok.error();
  if (motion_.time() && scan.time <= *motion_.time())
    return Error{ErrorCode::invalid, "a scan not later than the last: late or doubled"};
  return add(scan.time, ScanWeigher(scan, options_), odometry);
}

Result<LocalisationOutcome> Localiser::Engine::add_radar(LogTime time, const PointSet& points,
                                                         const std::optional<SE2d>& odometry) {
  if (!map_->has(RangeSensor::radar))
    return Error{ErrorCode::invalid, "the map knows nothing of what radar sees"};
  if (motion_.time() && time < *motion_.time())
    return Error{ErrorCode::invalid, "a radar scan earlier than the last scan"};
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite())
      return Error{ErrorCode::invalid, "a radar scan whose points are not finite"};
  return add(time, ScanWeigher(points, options_), odometry);
}

LocalisationOutcome Localiser::Engine::add(LogTime time, const ScanWeigher& scan,
                                           const std::optional<SE2d>& odometry) {
  LocalisationOutcome outcome;
  outcome.time = time;
  outcome.sensor = scan.sensor();
  if (!motion_.time() || time > *motion_.time()) outcome.odometry_refused = move_to(time, odometry);
  outcome.weighed = scan.enough() && memory_of(scan).says_something_new(time, options_);
  if (outcome.weighed) take(scan, outcome);
  outcome.T_map_base.covariance = Eigen::Matrix3d::Constant(INFINITY);
  if (!filter_) return outcome;
  const PoseBelief& belief = filter_->believe();
  motion_.tell(belief.pose.mean);
  outcome.T_map_base = belief.pose;
  outcome.mass = belief.mass;
  outcome.clusters = belief.clusters;
  outcome.particles = filter_->particles().size();
  if (outcome.weighed) {
    outcome.agreement = scan.agreement(*map_, belief.pose.mean);
    memory_of(scan).remember(outcome.agreement, belief.converged, options_.suspicion);
  }
  outcome.converged = belief.converged && !unbelievable();
  return outcome;
}

void Localiser::Engine::take(const ScanWeigher& scan, LocalisationOutcome& outcome) {
  SensorMemory& memory = memory_of(scan);
  memory.weighed_at = outcome.time;
  memory.since_weighed = SE2d();
  ++since_search_;
  if (!filter_) {
    filter_ = new_filter();
    filter_->start_anywhere(scan);
    since_search_ = 0;
    outcome.searched = true;
    return;
  }
  // One begun to make sure has the odds of its time against it: doubts begin anew.
  if (relocalisation_ && !relocalisation_->in_doubt && filter_->belief().converged && fits_badly())
    relocalisation_.reset();
  if (relocalisation_ || in_doubt()) {
    outcome.searched = !relocalisation_;
    challenge(scan);
  }
  if (filter_->belief().converged && memory.last < options_.suspicion * memory.usual)
    filter_->scatter();
  filter_->weigh(scan);
  filter_->resample_if_due();
  if (relocalisation_) settle(outcome);
}

// Scans fit worse than they used to; or the pose was told, or found from nowhere by one search
// only.
bool Localiser::Engine::in_doubt() const {
  const int wait = std::max(options_.scans_between_searches, 1);
  const PoseBelief& belief = filter_->belief();
  if (belief.converged && fits_badly()) return since_search_ >= wait;
  return (!belief.converged || !confirmed_) && since_search_ >= 4 * wait;
}

// Odds that the robot was carried away: prior odds, times what each scan since said of poses
// anywhere against what it said of the particles, each as the scans before left them.
void Localiser::Engine::challenge(const ScanWeigher& scan) {
  if (!relocalisation_) {
    const double prior = options_.kidnap_probability;
    relocalisation_ =
        RelocalisationHypothesis{new_filter(), std::log(prior / (1.0 - prior)), fits_badly()};
    relocalisation_->log_odds =
        log_odds_after(relocalisation_->log_odds, relocalisation_->filter.start_anywhere(scan),
                       filter_->log_evidence(scan, true));
  } else {
    PoseFilter& other = relocalisation_->filter;
    const bool broad = !other.belief().converged || !filter_->belief().converged;
    relocalisation_->log_odds =
        log_odds_after(relocalisation_->log_odds, other.log_evidence(scan, broad),
                       filter_->log_evidence(scan, broad));
    other.weigh(scan);
    other.resample_if_due();
  }
  relocalisation_->filter.believe();
  ++relocalisation_->scans[static_cast<std::size_t>(scan.sensor())];
}

void Localiser::Engine::settle(LocalisationOutcome& outcome) {
  constexpr double kDecided = 8.0;           // nats: odds of 3000 to 1
  constexpr int kFair = 30, kLongest = 100;  // scans: to show some promise, and in all
  const PoseBelief& theirs = relocalisation_->filter.belief();
  const PoseBelief& ours = filter_->believe();
  const bool same = theirs.converged && same_place(theirs.pose.mean, ours.pose.mean, options_);
  if (relocalisation_->log_odds > kDecided && !same) {
    filter_ = std::move(relocalisation_->filter);
    outcome.moved = true;
    for (SensorMemory& m : memories_) m.begin_anew();
    confirmed_ = given_ = false;
  } else if (same && ours.converged) {
    confirmed_ = true;
    for (SensorMemory& m : memories_) m.usual = m.recent;  // it fits no better anywhere
  } else if (relocalisation_->age() < (relocalisation_->log_odds < 0.0 ? kFair : kLongest)) {
    return;
  } else if (given_) {
    confirmed_ = true;
  }
  relocalisation_.reset();
  since_search_ = 0;
}

Localiser::Localiser(std::shared_ptr<const LocalisationMap> map, const LocalisationOptions& options,
                     std::uint64_t seed) {
  WAYFARE_EXPECTS(map != nullptr, "a localiser needs a map");
  engine_ = std::make_unique<Engine>(std::move(map), options, seed);
}
Localiser::~Localiser() = default;
Localiser::Localiser(Localiser&&) noexcept = default;
Localiser& Localiser::operator=(Localiser&&) noexcept = default;

Result<void> Localiser::start_at(const Gaussian<SE2d>& T_map_base) {
  return engine_->start_at(T_map_base);
}
void Localiser::start_anywhere() { engine_->start_anywhere(); }

Result<void> Localiser::add_motion(
    LogTime time, const std::optional<Transform2<frame::Odom, frame::Base>>& odometry) {
  return engine_->add_motion(time, raw(odometry));
}

Result<LocalisationOutcome> Localiser::add_scan(
    const LaserScan& scan, const std::optional<Transform2<frame::Odom, frame::Base>>& odometry) {
  return engine_->add_scan(scan, raw(odometry));
}

Result<LocalisationOutcome> Localiser::add_radar(
    LogTime time, const PointSet& points_base,
    const std::optional<Transform2<frame::Odom, frame::Base>>& odometry) {
  return engine_->add_radar(time, points_base, raw(odometry));
}

std::vector<PoseParticle> Localiser::particles() const {
  const ParticleSet& set = engine_->particles();
  std::vector<double> weights = set.log_weight;
  normalise(weights);
  std::vector<PoseParticle> result;
  result.reserve(set.size());
  for (std::size_t i = 0; i < set.size(); ++i)
    result.push_back({set.pose(i), std::exp(weights[i])});
  return result;
}

}  // namespace wayfare
