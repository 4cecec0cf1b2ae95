#pragma once

// Monte-Carlo localisation with a likelihood, a model of odometry and a map of your own:
//
//   struct ToBeacons {                                     // ranges to beacons at known places
//     double log_likelihood(const SE2d& pose, const Ranges& scan, const Beacons& map) const;
//   };
//   BasicLocaliser localiser(map, ToBeacons{}, OdometryNoise{}, MonteCarloOptions{}, 1);
//   const auto outcome = localiser.add_scan(time, ranges, odometry);
//
// Localiser of localisation.hpp is the one with the library's likelihoods, compiled once.

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/detail/call_guard.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/motion/odometry_model.hpp>
#include <wayfare/slam/detail/motion_guard.hpp>
#include <wayfare/slam/detail/pose_filter.hpp>
#include <wayfare/slam/detail/sensor_history.hpp>
#include <wayfare/slam/monte_carlo.hpp>
#include <wayfare/slam/scan_likelihood.hpp>

namespace wayfare {

/// `random_pose(rng)`: a pose anywhere in the map, evenly spread, for global localisation.
/// Optional: `free_area_m2()`, from which the number of poses follows.
template <class M, class Pose>
concept SearchableMap = requires(const M& map, Rng& rng) {
  { map.random_pose(rng) } -> std::convertible_to<Pose>;
};

namespace detail {

/// What the parts of a localiser lack, in words.
template <class Map, class Likelihood, class Odometry>
consteval bool check_localiser() {
  using Pose = LikelihoodPose<Likelihood>;
  static_assert(std::same_as<Pose, SE2d> || std::same_as<Pose, SE3d>,
                "wayfare: the Pose of a likelihood is SE2d or SE3d");
  static_assert(SearchableMap<Map, Pose>,
                "wayfare: a map for localisation has a const member random_pose(rng), with Rng&, "
                "which returns a pose anywhere in it");
  return check_odometry_model<Odometry, Pose>();
}

}  // namespace detail

/// Processes one scan at a time. Particles move by odometry and are weighted by the likelihood of
/// each scan; their number adapts to their spread. A second set, drawn over the whole map when
/// recent scans fit badly, takes over once the evidence says that the robot was kidnapped.
///
/// Not thread-safe; the same map, models, options, seed and input give the same bytes for any
/// number of threads. Any type of scan is accepted for which the likelihood is defined.
template <class Map, class Likelihood, class Odometry = OdometryNoise>
class BasicLocaliser {
  static_assert(detail::check_localiser<Map, Likelihood, Odometry>());

 public:
  using Pose = LikelihoodPose<Likelihood>;  ///< of the likelihood
  using Outcome = MonteCarloOutcome<Pose>;  ///< of one scan
  /// Poses and weights.
  using ParticleSet = typename detail::ParticlesOfLikelihood<Likelihood>::Type;
  using OdometryPose = Transform<frame::Odom, frame::Base, Pose>;  ///< odometry of that pose
  /// Whether the likelihood is defined for this type of scan.
  template <class Scan>
  static constexpr bool takes = ScanLikelihoodModel<Likelihood, Scan, Map>;

  /// The map must not be null. The initial state is that of start_anywhere.
  BasicLocaliser(std::shared_ptr<const Map> map, Likelihood likelihood, Odometry odometry,
                 const MonteCarloOptions& options, std::uint64_t seed)
      : map_(std::move(map)),
        likelihood_(std::move(likelihood)),
        odometry_(std::move(odometry)),
        options_(options),
        rng_(seed) {
    WAYFARE_EXPECTS(map_ != nullptr, "a localiser needs a map");
  }

  /// Draws the particles around a pose. Returns an Error if the pose is not finite or the
  /// covariance not positive semi-definite.
  Result<void> start_at(const Gaussian<Pose>& T_map_base) {
    if (!has_finite_value(T_map_base.mean) || !is_positive_semidefinite(T_map_base.covariance))
      return Error{ErrorCode::invalid,
                   "start_at: the pose is not finite or its covariance not positive semi-definite"};
    start_anywhere();
    return guard_.run([&]() -> Result<void> {
      filter_ = new_filter();
      filter_->start_at(T_map_base);
      pose_given_ = true;
      return {};
    });
  }

  /// Global localisation: the next scan is searched for in the whole map. This is also the initial
  /// state.
  void start_anywhere() {
    guard_.reset();
    filter_.reset();
    relocalisation_.reset();
    histories_ = {};
    confirmed_ = pose_given_ = false;
    since_search_ = 0;
  }

  /// Moves the particles by the odometry up to `time`, without a scan. For long gaps between scans:
  /// the noise then grows with the path driven rather than with the displacement. Returns an Error
  /// for a time not later than the last.
  Result<void> add_motion(LogTime time, const std::optional<OdometryPose>& odometry) {
    if (motion_.time() && time <= *motion_.time())
      return Error{ErrorCode::invalid, "a motion not later than the last"};
    return guard_.run([&]() -> Result<void> {
      move_to(time, odometry);
      return {};
    });
  }

  /// Processes the next scan with the odometry at its time, if any. Returns an Error and changes
  /// nothing for a scan earlier than the last.
  template <class Scan>
  Result<Outcome> add_scan(LogTime time, const Scan& scan,
                           const std::optional<OdometryPose>& odometry) {
    if (motion_.time() && time < *motion_.time())
      return Error{ErrorCode::invalid, "a scan earlier than the last"};
    return guard_.run([&]() -> Result<Outcome> {
      return add(time, detail::prepare_scan<Map>(likelihood_, scan, options_), odometry);
    });
  }

  /// Empty before the first scan that is used.
  [[nodiscard]] const ParticleSet& particles() const {
    static const ParticleSet none;
    return filter_ ? filter_->particles() : none;
  }
  /// As given.
  [[nodiscard]] const Map& map() const { return *map_; }
  /// Of the last scan or motion.
  [[nodiscard]] const std::optional<LogTime>& time() const { return motion_.time(); }

 private:
  static constexpr std::size_t kSensors = detail::sensors_of<Likelihood>();
  using Filter = detail::PoseFilter<ParticleSet, Map>;
  using Estimate = detail::PoseEstimate<Pose>;
  using History = detail::SensorHistory<Pose>;

  /// Returns true if odometry could not be used.
  bool move_to(LogTime time, const std::optional<OdometryPose>& odometry) {
    const bool first = !motion_.time();
    const auto step = motion_.step(time, odometry ? std::optional(odometry->raw()) : std::nullopt);
    if (first) return step.refused;
    if (step.predicted) {
      if constexpr (requires { odometry_.prediction(step.increment); }) {
        move(detail::motion_sampler<Pose>(odometry_.prediction(step.increment)));
      } else {
        move(sampler_of_odometry<Pose>(odometry_, step.increment));
      }
    } else {
      move(sampler_of_odometry<Pose>(odometry_, step.increment));
    }
    for (History& h : histories_) h.since_weighed = h.since_weighed * step.increment;
    return step.refused;
  }
  template <class Sampler>
  void move(const Sampler& sampler) {
    if (filter_) filter_->move(sampler);
    if (relocalisation_) relocalisation_->filter.move(sampler);
  }

  template <class Scan>
  Outcome add(LogTime time, const Scan& scan, const std::optional<OdometryPose>& odometry) {
    Outcome outcome;
    outcome.time = time;
    if (!motion_.time() || time > *motion_.time())
      outcome.odometry_refused = move_to(time, odometry);
    outcome.weighed = scan.enough() && history_of(scan).is_due(time, options_);
    if (outcome.weighed) apply(scan, outcome);
    outcome.T_map_base.covariance.setConstant(std::numeric_limits<double>::infinity());
    if (!filter_) return outcome;
    const Estimate& estimate = filter_->update_estimate();
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

  template <class Scan>
  void apply(const Scan& scan, Outcome& outcome) {
    History& history = history_of(scan);
    history.weighed_at = outcome.time;
    history.since_weighed = Pose::identity();
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
    outcome.refused_likelihoods = filter_->weigh(scan);
    filter_->resample_if_due();
    if (relocalisation_) resolve_hypothesis(outcome);
  }

  /// Odds that the robot was kidnapped: the prior, times each scan's evidence for poses anywhere
  /// over its evidence for the current particles, each weighted by the scans before.
  template <class Scan>
  void update_hypothesis(const Scan& scan) {
    if (!relocalisation_) {
      const double prior = options_.kidnap_probability;
      relocalisation_ = Hypothesis{new_filter(), std::log(prior / (1.0 - prior)), fit_is_poor()};
      relocalisation_->log_odds = detail::log_odds_after(
          relocalisation_->log_odds, relocalisation_->filter.start_anywhere(scan),
          filter_->log_evidence(scan, true));
    } else {
      Filter& other = relocalisation_->filter;
      const bool broad = !other.estimate().converged || !filter_->estimate().converged;
      relocalisation_->log_odds =
          detail::log_odds_after(relocalisation_->log_odds, other.log_evidence(scan, broad),
                                 filter_->log_evidence(scan, broad));
      other.weigh(scan);
      other.resample_if_due();
    }
    relocalisation_->filter.update_estimate();
    ++relocalisation_->scans[static_cast<std::size_t>(scan.sensor())];
  }

  void resolve_hypothesis(Outcome& outcome) {
    constexpr double kDecisive = 8.0;              // nats: odds of 3000 to 1
    constexpr int kPatience = 30, kLongest = 100;  // scans: without promising odds, and in total
    const Estimate& other = relocalisation_->filter.estimate();
    const Estimate& current = filter_->update_estimate();
    const bool same = other.converged && same_place(other.pose.mean, current.pose.mean);
    if (relocalisation_->log_odds > kDecisive && !same) {
      filter_ = std::move(relocalisation_->filter);
      outcome.relocalised = true;
      for (History& h : histories_) h.reset_recent();
      confirmed_ = pose_given_ = false;
    } else if (same && current.converged) {
      confirmed_ = true;
      for (History& h : histories_) h.usual = h.recent;  // no pose fits better
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
    const Estimate& estimate = filter_->estimate();
    if (estimate.converged && fit_is_poor()) return since_search_ >= wait;
    return (!estimate.converged || !confirmed_) && since_search_ / 4 >= wait;
  }

  [[nodiscard]] bool same_place(const Pose& a, const Pose& b) const {
    return (a.translation() - b.translation()).norm() < options_.bin_m &&
           detail::turn_between(a, b) < options_.bin_turn.radians();
  }
  [[nodiscard]] bool fit_is_poor() const {
    return std::any_of(histories_.begin(), histories_.end(), [&](const History& h) {
      return h.fits_worse_than(options_.search_ratio * h.usual);
    });
  }
  [[nodiscard]] bool agreement_is_poor() const {
    return std::any_of(histories_.begin(), histories_.end(), [&](const History& h) {
      return h.fits_worse_than(options_.rejection_ratio * h.best);
    });
  }
  template <class Scan>
  [[nodiscard]] History& history_of(const Scan& scan) {
    return histories_[static_cast<std::size_t>(scan.sensor())];
  }
  [[nodiscard]] Filter new_filter() { return {map_, options_, rng_.stream(filters_++)}; }

  using Hypothesis = detail::RelocalisationHypothesis<Filter, kSensors>;

  std::shared_ptr<const Map> map_;
  Likelihood likelihood_;
  detail::CallGuard guard_;
  Odometry odometry_;
  MonteCarloOptions options_;
  Rng rng_;
  std::uint64_t filters_ = 0;
  detail::MotionGuard<Pose> motion_{options_};
  std::optional<Filter> filter_;  // none where nothing is known
  std::optional<Hypothesis> relocalisation_;
  std::array<History, kSensors> histories_;
  bool confirmed_ = false;   // a global search found the same pose
  bool pose_given_ = false;  // the pose was given: one search without a better result confirms it
  int since_search_ = 0;     // scans weighted
};

}  // namespace wayfare
