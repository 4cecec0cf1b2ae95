#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <wayfare/core/parallel.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/detail/scans.hpp>
#include <wayfare/slam/radar_slam.hpp>

#include "slam/radar_slam/gyro_bias.hpp"
#include "slam/radar_slam/loop_smoother.hpp"
#include "slam/radar_slam/mapped_scan.hpp"
#include "slam/radar_slam/sensor_step.hpp"

namespace wayfare {

/// A scan with the motion since the previous update, predicted or matched.
struct PlacedScan {
  LogTime time;
  std::size_t update;
  SE2d since;
  bool matched = false;
};

/// The filter on scans at once: one hypothesis of the map for each particle.
class ScanFilter {
 public:
  /// Particles begin at `start`.
  ScanFilter(const detail::MakeParticleMatcher& make, const RadarSlamOptions& options,
             const SE2d& start)
      : options_(consistent(options)), start_(start), smoother_(options_) {
    const std::size_t threads = static_cast<std::size_t>(std::max(1, options.threads));
    for (std::size_t k = 0; k < std::min(threads, options.particles); ++k)
      workers_.push_back({{SensorStep(options_.lidar, options.proposal, make()),
                           SensorStep(options_.radar, options.proposal, make())},
                          MapMaker(options_)});
  }

  Result<void> move(const BiasedMotion& increment) {
    const BiasedMotion moved = compose(moved_, increment);
    const auto valid = [](const Gaussian<SE2d>& g) {
      return detail::finite(g.mean) && is_positive_semidefinite(g.covariance);
    };
    if (!valid(increment.raw) || !detail::finite(moved.raw.mean) ||
        !moved.raw.covariance.allFinite() || !(increment.gyro_s >= 0.0) ||
        !std::isfinite(moved.gyro_s))
      return Error{ErrorCode::invalid,
                   "the motion is not finite or its covariance not positive semi-definite"};
    if (filter_) {
      moved_ = moved;
      tracked_ = tracked_ * increment.raw.mean;
    }
    return {};
  }

  /// From the last scan to the next one, in place of motion since.
  void relocate(const Gaussian<SE2d>& increment) {
    moved_ = {{scans_.back().since * increment.mean, increment.covariance}};
    tracked_ = moved_.raw.mean;
  }

  /// Points of a scan in the base frame; `scan` is that of a LiDAR.
  Result<RbpfOutcome> process(LogTime time, Sensor sensor, const PointSet& points,
                              const LaserScan* scan) {
    ++statistics_.scans;
    const RbpfSensorOptions& options = of(sensor);
    const bool enough = points.size() >= options.min_points;
    statistics_.without_points += enough ? 0 : 1;
    if (!filter_) begin(time);
    Result<RbpfOutcome> outcome = RbpfOutcome{};
    std::optional<Gaussian<SE2d>> seen;  // motion since the last update, by a match
    MatcherErrors errors;
    bool now = due(time, sensor, moved_.raw.mean);
    if (enough && !now && sensor == kLidar && options_.match_skipped) {
      if (const auto match = motion_by_match(points, errors)) seen = match->pose;
      now = seen && due(time, sensor, seen->mean);
    }
    if (enough && now) {
      outcome = update(time, sensor, points, scan, errors);
      seen.reset();
    }
    MatcherErrors placed;
    placed.add(errors, "scan");
    statistics_.matcher_errors.add(placed);
    if (outcome) outcome->matcher_errors = std::move(placed);
    const Gaussian<SE2d> since = seen.value_or(moved_.raw);
    scans_.push_back({time, increments_.size(), since.mean, seen.has_value()});
    since_ = since.covariance;
    return outcome;
  }

  [[nodiscard]] Trajectory trajectory() const {
    return filter_ ? trajectory(filter_->best()) : Trajectory();
  }
  [[nodiscard]] Trajectory trajectory(std::size_t particle) const {
    const Trajectory path = this->path(particle);
    Trajectory poses;
    for (const PlacedScan& s : scans_) poses.push_back({s.time, pose_of(path, s)});
    return poses;
  }
  [[nodiscard]] std::optional<StampedPose> pose() const {
    if (scans_.empty()) return std::nullopt;
    const SE2d& updated = filter_->particles()[filter_->best()].pose;
    return StampedPose{scans_.back().time, MapPose(updated * scans_.back().since)};
  }
  /// Relative to the start: of the best particle's path, of the particles about its end, and of the
  /// match or the motion since.
  [[nodiscard]] Eigen::Matrix3d covariance() const {
    if (!filter_) return Eigen::Matrix3d::Zero();
    const SE2d& best = filter_->particles()[filter_->best()].pose;
    Eigen::Matrix3d sum = smoother_.covariance(path(filter_->best()));
    for (std::size_t i = 0; i < filter_->particles().size(); ++i) {
      const Eigen::Vector3d off = filter_->particles()[i].pose.minus(best);
      sum += std::exp(filter_->log_weights()[i]) * off * off.transpose();
    }
    return compose(Gaussian<SE2d>{best, sum}, Gaussian<SE2d>{scans_.back().since, since_})
        .covariance;
  }
  /// Of scans.
  [[nodiscard]] std::size_t size() const { return scans_.size(); }
  [[nodiscard]] const Rbpf<RbpfMaps>* filter() const { return filter_ ? &*filter_ : nullptr; }
  [[nodiscard]] const RbpfMaps& maps() const {
    return filter_ ? filter_->particles()[filter_->best()].map : blank_;
  }
  [[nodiscard]] const RbpfStatistics& statistics() const { return statistics_; }

 private:
  struct Worker {
    std::array<SensorStep, 2> match;  // of LiDAR and radar
    MapMaker map;
  };
  /// Of LiDAR or radar.
  struct SensorState {
    bool has_scans = false;  // in the filter
    SE2d at_map, at_update;  // pose of the last scan in the maps, and in the filter, relative to
                             // the last update
  };

  /// The density of detections is that of the map.
  [[nodiscard]] static RadarSlamOptions consistent(RadarSlamOptions options) {
    if (options.radar.density)
      options.radar.density->hit_probability = options.radar_hit_probability;
    return options;
  }

  /// Step 3: all particles at the start, with empty maps.
  void begin(LogTime time) {
    filter_.emplace(options_.particles, StampedPose{time, MapPose(start_)}, blank_, options_.seed);
    updated_ = time;
  }

  [[nodiscard]] const RbpfSensorOptions& of(Sensor sensor) const {
    return sensor == kLidar ? options_.lidar : options_.radar;
  }
  [[nodiscard]] bool map_due(Sensor sensor) const {
    const SensorState& s = sensors_[sensor];
    return !s.has_scans || reaches(s.at_map.inverse() * moved_.raw.mean, of(sensor).map_travel_m,
                                   of(sensor).map_turn);
  }
  [[nodiscard]] bool due(LogTime time, Sensor sensor, const SE2d& motion) const {
    const SensorState& s = sensors_[sensor];
    return !s.has_scans ||
           reaches(s.at_update.inverse() * motion, options_.update_travel_m,
                   options_.update_turn) ||
           to_seconds(time - updated_) >= options_.update_time_s;
  }

  /// The motion since the last update, by matching to the best particle's map. Not used as motion
  /// of the next update: the same walls would count twice, and a robot creeping along a corridor
  /// would never seem to have moved.
  std::optional<ScanMatch> motion_by_match(const PointSet& points, MatcherErrors& errors) {
    const RbpfParticle<RbpfMaps>& best = filter_->particles()[filter_->best()];
    const Gaussian<SE2d> moved = without_bias(moved_, best.map.gyro_bias);
    Gaussian<SE2d> expected{best.pose * moved.mean, moved.covariance};
    expected.covariance += 1e-10 * Eigen::Matrix3d::Identity();
    const auto found = workers_.front().match[kLidar].track(best.map.lidar, points, expected,
                                                            best.pose * tracked_);
    errors.add(workers_.front().match[kLidar].take_errors());
    statistics_.matches_gated += workers_.front().match[kLidar].take_gated();
    if (!found) return std::nullopt;
    tracked_ = best.pose.inverse() * found->pose.mean;
    return ScanMatch{{tracked_, found->pose.covariance}, found->score, found->fit, found->widened};
  }

  /// Steps 4 to 8.
  Result<RbpfOutcome> update(LogTime time, Sensor sensor, const PointSet& points,
                             const LaserScan* scan, MatcherErrors& errors) {
    BiasedMotion motion = moved_;
    motion.raw.covariance += 1e-10 * Eigen::Matrix3d::Identity();
    const double interval_s = to_seconds(time - updated_);
    const bool first = !sensors_[sensor].has_scans, map_due_now = map_due(sensor);
    std::optional<ScanMatch> seen_by_best;
    if (!first && sensor == kLidar) seen_by_best = motion_by_match(points, errors);
    if (seen_by_best && seen_by_best->widened) seen_by_best.reset();
    const PointSet seen =
        map_due_now && scan != nullptr ? workers_.front().map.walls_of(*scan) : points;
    std::vector<DrawnPose> drawn(options_.particles);
    std::vector<MatcherErrors> errors_of(options_.particles);
    std::vector<std::size_t> gated(options_.particles, 0);
    const auto step = [&](RbpfParticle<RbpfMaps>& particle, Rng& rng, std::size_t w) {
      Worker& worker = workers_[w];
      GyroBias& bias = particle.map.gyro_bias;
      predict(bias, options_.gyro_bias, interval_s);
      const Gaussian<SE2d> moved = without_bias(motion, bias);
      const Gaussian<SE2d> expected{particle.pose * moved.mean, moved.covariance};
      std::optional<ScanMatch> near = seen_by_best;
      if (near) near->pose.mean = particle.pose * near->pose.mean;
      const OccupancyGrid& grid = sensor == kLidar ? particle.map.lidar : particle.map.radar;
      const DrawnPose s = first ? DrawnPose{sample(expected, rng)}
                                : worker.match[sensor].draw_pose(
                                      grid, points, expected, particle.pose * tracked_, near, rng);
      wayfare::update(bias, motion,
                      (particle.pose.rotation().inverse() * s.pose.rotation()).angle());
      particle.pose = s.pose;
      if (map_due_now) worker.map.insert(particle.map, particle.pose, sensor, seen);
      const auto index = static_cast<std::size_t>(&particle - filter_->particles().data());
      drawn[index] = s;
      errors_of[index] = worker.match[sensor].take_errors();
      gated[index] = worker.match[sensor].take_gated();
      return s.log_factor;
    };
    const auto weighed = filter_->update(time, step, [&](std::size_t n, const auto& f) {
      parallel_for_workers(n, options_.threads, f);
    });
    for (const MatcherErrors& e : errors_of) errors.add(e);
    RbpfOutcome outcome;
    outcome.updated = true;
    if (weighed) outcome.particles_refused = weighed->refused;
    for (const DrawnPose& s : drawn) {
      outcome.matched += s.matched ? 1 : 0;
      outcome.mean_score += s.score;
    }
    if (outcome.matched > 0) outcome.mean_score /= static_cast<double>(outcome.matched);
    outcome.effective_particles = filter_->effective_particles();
    outcome.resampled = filter_->resample_below(options_.resample_below);
    ++statistics_.updates;
    statistics_.matches += outcome.matched;
    statistics_.matches_refused += first ? 0 : drawn.size() - outcome.matched;
    for (const std::size_t g : gated) statistics_.matches_gated += g;
    statistics_.resampled += outcome.resampled ? 1 : 0;
    // Start of the next motion.
    increments_.push_back(moved_.raw.mean);
    for (SensorState& s : sensors_) {
      s.at_update = moved_.raw.mean.inverse() * s.at_update;
      s.at_map = moved_.raw.mean.inverse() * s.at_map;
    }
    if (map_due_now) sensors_[sensor].at_map = SE2d();
    sensors_[sensor].at_update = SE2d();
    sensors_[sensor].has_scans = true;
    moved_ = {};
    tracked_ = SE2d();
    updated_ = time;
    if (!weighed) return weighed.error();
    if (map_due_now)
      close_loop({increments_.size() - 1, sensor, points,
                  scan != nullptr ? std::optional(*scan) : std::nullopt});
    return outcome;
  }

  /// The filter goes on from the smoothed path, where a loop closed, with its map.
  void close_loop(MappedScan scan) {
    const RbpfParticle<RbpfMaps>& best = filter_->particles()[filter_->best()];
    smoother_.add(std::move(scan), best.pose);
    const auto smoothed = smoother_.smooth(path(filter_->best()));
    if (!smoothed) return;
    RbpfMaps blank = blank_;
    blank.gyro_bias = best.map.gyro_bias;
    const RbpfMaps maps = smoother_.maps(*smoothed, blank);
    Trajectory earlier(smoothed->begin(), smoothed->end() - 1);
    filter_ = Rbpf<RbpfMaps>(options_.particles, smoothed->back(), maps,
                             options_.seed + statistics_.loops_closed + 1);
    earlier_ = std::move(earlier);
    ++statistics_.loops_closed;
  }

  /// One pose per update, after the start.
  [[nodiscard]] Trajectory path(std::size_t particle) const {
    Trajectory path = earlier_;
    const Trajectory since = filter_->trajectory(particle);
    path.insert(path.end(), since.begin(), since.end());
    return path;
  }

  /// Along the predicted motion, corrected linearly in time to end at the next update.
  [[nodiscard]] MapPose pose_of(const Trajectory& path, const PlacedScan& s) const {
    const SE2d start = path[s.update].T_map_base.raw();
    if (s.matched || s.update >= increments_.size()) return MapPose(start * s.since);
    const SE2d end = path[s.update + 1].T_map_base.raw();
    const double whole = to_seconds(path[s.update + 1].time - path[s.update].time);
    const double part = whole > 0 ? to_seconds(s.time - path[s.update].time) / whole : 0.0;
    const Eigen::Vector3d gap = end.minus(start * increments_[s.update]);
    return MapPose((start * s.since).plus(part * gap));
  }

  RadarSlamOptions options_;
  SE2d start_;
  std::vector<Worker> workers_;
  RbpfMaps blank_{OccupancyGrid(options_.lidar.grid),
                  OccupancyGrid(options_.radar.grid),
                  {0.0, options_.gyro_bias.sigma_rad_s* options_.gyro_bias.sigma_rad_s}};
  std::optional<Rbpf<RbpfMaps>> filter_;
  LoopSmoother smoother_;
  BiasedMotion moved_;  // since the last update
  SE2d tracked_;        // the same by the best particle's matches, then motion
  std::array<SensorState, 2> sensors_;
  Eigen::Matrix3d since_ = Eigen::Matrix3d::Zero();  // of the latest scan since the last update
  LogTime updated_;
  Trajectory earlier_;            // path up to the last loop closed
  std::vector<SE2d> increments_;  // from each update to the next
  std::vector<PlacedScan> scans_;
  RbpfStatistics statistics_;
};

}  // namespace wayfare
