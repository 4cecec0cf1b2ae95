#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include <wayfare/estimate/particles.hpp>
#include <wayfare/system/localisation.hpp>

#include "localisation/motion_guard.hpp"
#include "localisation/pose_filter.hpp"
#include "localisation/scan_weigher.hpp"

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
struct Challenger {
  PoseFilter filter;
  double log_odds;  ///< that it, and not the first, is right
  int scans = 0;
};

bool same_place(const SE2d& a, const SE2d& b, const LocalisationOptions& options) {
  return (a.translation() - b.translation()).norm() < options.bin_m &&
         std::abs((a.heading() - b.heading()).wrapped().radians()) < options.bin_turn.radians();
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

  [[nodiscard]] const ParticleSet& particles() const {
    static const ParticleSet none;
    return filter_ ? filter_->particles() : none;
  }

 private:
  bool move_to(LogTime time, const std::optional<SE2d>& odometry);
  [[nodiscard]] bool says_something_new(LogTime time) const;
  void take(const ScanWeigher& scan, LocalisationOutcome& outcome);
  void challenge(const ScanWeigher& scan);
  void settle(LocalisationOutcome& outcome);
  void remember(double agreement);
  [[nodiscard]] bool in_doubt() const;
  [[nodiscard]] bool fits_badly() const { return recent_ < options_.suspicion * usual_; }
  [[nodiscard]] PoseFilter new_filter() { return {map_, options_, rng_.stream(filters_++)}; }

  std::shared_ptr<const LocalisationMap> map_;
  LocalisationOptions options_;
  Rng rng_;
  std::uint64_t filters_ = 0;
  MotionGuard motion_{options_};
  std::optional<PoseFilter> filter_;  // none where nothing is known
  std::optional<Challenger> challenger_;
  SE2d since_weighed_;  // motion since the last scan that was weighed
  std::optional<LogTime> weighed_at_;
  double usual_ = 0.0, recent_ = 0.0, last_ = 0.0;  // agreement while converged, of late, last
  bool confirmed_ = false;                          // a search from nowhere came to the same pose
  int since_search_ = 0;                            // scans weighed
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
  confirmed_ = true;  // by whoever gave it
  return {};
}

void Localiser::Engine::start_anywhere() {
  filter_.reset();
  challenger_.reset();
  usual_ = recent_ = 0.0;
  confirmed_ = false;
  since_search_ = 0;
  weighed_at_.reset();
}

// True where odometry could not be used.
bool Localiser::Engine::move_to(LogTime time, const std::optional<SE2d>& odometry) {
  const bool first = !motion_.time();
  const MotionGuard::Step step = motion_.step(time, odometry);
  if (first) return step.refused;
  if (filter_) filter_->move(step.motion);
  if (challenger_) challenger_->filter.move(step.motion);
  since_weighed_ = since_weighed_ * step.motion.mean;
  return step.refused;
}

Result<void> Localiser::Engine::add_motion(LogTime time, const std::optional<SE2d>& odometry) {
  if (motion_.time() && time <= *motion_.time())
    return Error{ErrorCode::invalid, "a motion not later than the last"};
  move_to(time, odometry);
  return {};
}

bool Localiser::Engine::says_something_new(LogTime time) const {
  return !weighed_at_ || since_weighed_.translation().norm() >= options_.between_m ||
         std::abs(since_weighed_.heading().radians()) >= options_.between_turn.radians() ||
         to_seconds(time - *weighed_at_) >= options_.between_s;
}

Result<LocalisationOutcome> Localiser::Engine::add_scan(const LaserScan& scan,
                                                        const std::optional<SE2d>& odometry) {
  if (auto ok = check(scan); !ok) return ok.error();
  if (motion_.time() && scan.time <= *motion_.time())
    return Error{ErrorCode::invalid, "a scan not later than the last: late or doubled"};
  LocalisationOutcome outcome;
  outcome.time = scan.time;
  outcome.odometry_refused = move_to(scan.time, odometry);
  const ScanWeigher weigher(scan, options_);
  outcome.weighed = weigher.enough() && says_something_new(scan.time);
  if (outcome.weighed) take(weigher, outcome);
  outcome.T_map_base.covariance = Eigen::Matrix3d::Constant(INFINITY);
  if (!filter_) return outcome;
  const PoseBelief& belief = filter_->believe();
  motion_.tell(belief.pose.mean);
  outcome.T_map_base = belief.pose;
  outcome.converged = belief.converged;
  outcome.mass = belief.mass;
  outcome.clusters = belief.clusters;
  outcome.particles = filter_->particles().size();
  if (outcome.weighed) {
    outcome.agreement = weigher.agreement(*map_, belief.pose.mean);
    remember(outcome.agreement);
  }
  return outcome;
}

void Localiser::Engine::take(const ScanWeigher& scan, LocalisationOutcome& outcome) {
  weighed_at_ = outcome.time;
  since_weighed_ = SE2d();
  ++since_search_;
  if (!filter_) {
    filter_ = new_filter();
    filter_->start_anywhere(scan);
    since_search_ = 0;
    outcome.searched = true;
    return;
  }
  if (challenger_ || in_doubt()) {
    outcome.searched = !challenger_;
    challenge(scan);
  }
  if (filter_->belief().converged && last_ < options_.suspicion * usual_) filter_->scatter();
  filter_->weigh(scan);
  filter_->resample_if_due();
  if (challenger_) settle(outcome);
}

// Scans fit worse than they used to; or the pose was found from nowhere and by one search only.
bool Localiser::Engine::in_doubt() const {
  const int wait = std::max(options_.scans_between_searches, 1);
  const PoseBelief& belief = filter_->belief();
  if (!belief.converged || !confirmed_) return since_search_ >= 4 * wait;
  return since_search_ >= wait && fits_badly();
}

// Odds that the robot was carried away: prior odds, times what each scan since said of poses
// anywhere against what it said of the particles, each as the scans before left them.
void Localiser::Engine::challenge(const ScanWeigher& scan) {
  if (!challenger_) {
    const double prior = options_.kidnap_probability;
    challenger_ = Challenger{new_filter(), std::log(prior / (1.0 - prior))};
    challenger_->log_odds +=
        challenger_->filter.start_anywhere(scan) - filter_->log_evidence(scan, true);
  } else {
    PoseFilter& other = challenger_->filter;
    const bool broad = !other.belief().converged || !filter_->belief().converged;
    challenger_->log_odds += other.log_evidence(scan, broad) - filter_->log_evidence(scan, broad);
    other.weigh(scan);
    other.resample_if_due();
  }
  challenger_->filter.believe();
  ++challenger_->scans;
}

void Localiser::Engine::settle(LocalisationOutcome& outcome) {
  constexpr double kDecided = 8.0;           // nats: odds of 3000 to 1
  constexpr int kFair = 30, kLongest = 100;  // scans: to show some promise, and in all
  const PoseBelief& theirs = challenger_->filter.belief();
  const PoseBelief& ours = filter_->believe();
  const bool same = theirs.converged && same_place(theirs.pose.mean, ours.pose.mean, options_);
  if (challenger_->log_odds > kDecided && !same) {
    filter_ = std::move(challenger_->filter);
    outcome.moved = true;
    usual_ = recent_ = 0.0;
    confirmed_ = false;
  } else if (same && ours.converged) {
    confirmed_ = true;
    usual_ = recent_;  // it fits no better anywhere
  } else if (challenger_->scans < (challenger_->log_odds < 0.0 ? kFair : kLongest)) {
    return;
  }
  challenger_.reset();
  since_search_ = 0;
}

void Localiser::Engine::remember(double agreement) {
  constexpr double kFast = 0.3, kSlow = 0.02;
  last_ = agreement;
  recent_ += (recent_ == 0.0 ? 1.0 : kFast) * (agreement - recent_);
  if (!filter_->belief().converged) return;
  // Slower still while in doubt, or what was usual would follow the robot that was carried away.
  const double rate = fits_badly() ? 0.1 * kSlow : kSlow;
  usual_ += (usual_ == 0.0 ? 1.0 : rate) * (agreement - usual_);
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
