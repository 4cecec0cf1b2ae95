#include <wayfare/slam/hector_slam.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <Eigen/LU>

#include <wayfare/core/detail/call_guard.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/pose_history.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/detail/scans.hpp>

#include "slam/hector_slam/map_uncertainty.hpp"
#include "slam/matched.hpp"

namespace wayfare {

class HectorSlamSystem::Engine {
 public:
  Engine(const HectorSlamOptions& options, const detail::MakeHectorMap& make_map)
      : options_(options),
        map_(with_tables_near(options)),
        matched_(make_map(map_)),
        carrier_(options.carrier),
        motion_model_(options.odometry, options.constant_velocity),
        uncertainty_(options.drift) {}

  UpdateStatus add(const ImuSample& s) {
    const UpdateStatus status = carrier_.add({s.time, options_.q_base_unit * s.angular_rate_radps,
                                              options_.q_base_unit * s.specific_force_mps2});
    if (statistics_.carrier_starts != carrier_.starts()) motion_.clear();
    statistics_.carrier_starts = carrier_.starts();
    if (status == UpdateStatus::used) remember_motion(s.time);
    return status;
  }

  Result<ScanOutcome> add_scan(const LaserScan& scan, const std::optional<SE2d>& odometry) {
    return guard_.run([&] { return add(scan, odometry); });
  }
  Result<ScanOutcome> add(const LaserScan& scan, const std::optional<SE2d>& odometry) {
    if (auto ok = detail::check_scan(scan, odometry, trajectory_); !ok) return ok.error();
    has_imu_ = carrier_.covers(scan.end_time());
    const LogTime time = has_imu_ ? scan.end_time() : scan.time;
    if (has_imu_) carrier_.advance(time);
    if (has_imu_) remember_motion(time);
    level_known_ = has_imu_ && carrier_.level_sigma() < options_.level_sigma;
    const View view = level_known_ ? level(scan) : View{&scan, options_.T_base_laser.raw()};
    const PointSet points = points_of(view);
    errors_ = {};
    ScanOutcome outcome;
    if (map_.empty()) {
      pose_ = odometry.value_or(SE2d());
      outcome.matched = true;
    } else {
      auto placed = place(points, predict(time, odometry), alternative_to_odometry(time, odometry));
      if (!placed) return placed;
      outcome = *placed;
    }
    if (outcome.matched && map_update_due(pose_)) {
      const auto inserted = insert_into_map(view, points);
      if (!inserted && map_.empty()) return inserted.error();
      outcome.became_node = inserted.has_value();
    }
    if (has_imu_ && !carrier_.placed())
      carrier_.place(pose_, options_.min_sigma_m, options_.min_sigma);
    motion_.clear();  // the match has moved the filter's pose
    if (has_imu_) remember_motion(time);
    motion_model_.update(time, pose_, odometry);
    coasting_ = has_imu_ && !outcome.matched;
    outcome.T_map_base = MapPose(pose_);
    outcome.matcher_errors.add(errors_, "scan");
    statistics_.matcher_errors.add(outcome.matcher_errors);
    trajectory_.push_back({time, outcome.T_map_base});
    ++statistics_.scans;
    statistics_.levelled_scans += level_known_ ? 1 : 0;
    statistics_.unmatched_scans += outcome.matched ? 0 : 1;
    return outcome;
  }

  [[nodiscard]] const Trajectory& trajectory() const { return trajectory_; }
  [[nodiscard]] Eigen::Matrix3d covariance() const { return uncertainty_.at(pose_, placed_); }
  [[nodiscard]] const OccupancyGrid& map() const { return map_.finest(); }
  [[nodiscard]] std::size_t memory_bytes() const { return map_.memory_bytes(); }
  [[nodiscard]] const HectorStatistics& statistics() const { return statistics_; }
  [[nodiscard]] const CarrierFilter& carrier() const { return carrier_; }

 private:
  /// Scans are matched to tables of what they can reach, not of the whole map.
  static MultiResolutionOptions with_tables_near(const HectorSlamOptions& options) {
    constexpr double kSearch_m = 10.0;
    MultiResolutionOptions map = options.map;
    map.table_reach_m = std::min(map.table_reach_m, std::max(options.max_range_m, 0.0) + kSearch_m);
    return map;
  }

  /// A scan and its sensor's pose.
  struct View {
    const LaserScan* scan;
    SE2d T_base_laser;
  };
  /// The predicted pose, with its uncertainty in the pose's own axes.
  struct Predicted {
    SE2d pose;
    Eigen::Vector3d sigma;
    Eigen::Matrix3d information;
    double search_sigmas;
    bool in_map = false;  ///< in the map, not since the last scan
  };

  /// The levelled scan, its x axis along the heading.
  View level(const LaserScan& scan) {
    const SE2d& mounted = options_.T_base_laser.raw();
    const SO3d q = carrier_.q_level_body();
    const SO3d q_base_laser =
        SO3d::exp(Eigen::Vector3d(0, 0, mounted.rotation().angle().radians()));
    const Eigen::Vector3d at(mounted.x(), mounted.y(), 0);
    if (!scan.is_sweep() || !level_sweep(scan, SE3d(at, q_base_laser)))
      levelled_ = level_scan(scan, q * q_base_laser, options_.level);
    return {&levelled_, SE2d(Eigen::Vector2d((q * at).head<2>()), SO2d())};
  }

  /// By the motion that the filter found during the sweep. False where it did not cover all of it.
  bool level_sweep(const LaserScan& scan, const SE3d& T_base_laser) {
    const SO3d to_heading =
        SO3d::exp(-carrier_.planar().heading().radians() * Eigen::Vector3d::UnitZ());
    const auto laser = [&](LogTime time) -> std::optional<SE3d> {
      const auto T_map_base = motion_(time);
      if (!T_map_base) return std::nullopt;
      return SE3d(Eigen::Vector3d::Zero(), to_heading) * *T_map_base * T_base_laser;
    };
    return level_scan(scan, laser, scan.end_time(), levelled_, options_.level).has_value();
  }

  void remember_motion(LogTime time) {
    const CarrierState& x = carrier_.state();
    (void)motion_.add(time, SE3d(x.position_m, x.q_map_body));  // where it is later than the last
  }

  [[nodiscard]] Predicted predict(LogTime time, const std::optional<SE2d>& odometry) const {
    const Motion motion = motion_model_.predict(time, odometry);
    if (!(level_known_ && carrier_.placed()) || odometry)
      return {pose_ * motion.increment, motion.sigma, information_of(motion.sigma),
              motion.measured ? options_.search_sigmas : options_.velocity_search_sigmas};
    Eigen::Matrix3d p = carrier_.planar_covariance();
    p.diagonal() +=
        Eigen::Vector3d(options_.min_sigma_m, options_.min_sigma_m, options_.min_sigma.radians())
            .cwiseAbs2();
    return {carrier_.planar(), p.diagonal().cwiseSqrt(), p.inverse(), options_.search_sigmas, true};
  }

  /// Constant-velocity prediction, where odometry contradicts it.
  struct Alternative {
    SE2d pose;
    bool jumps;  ///< by a large distance
  };
  [[nodiscard]] std::optional<Alternative> alternative_to_odometry(
      LogTime time, const std::optional<SE2d>& odometry) const {
    if (!odometry) return std::nullopt;
    const Motion by_odometry = motion_model_.predict(time, odometry);
    const Motion by_velocity = motion_model_.predict(time, {});
    if (!contradicts(by_odometry, by_velocity, options_.search_sigmas)) return std::nullopt;
    return Alternative{pose_ * by_velocity.increment, jumps(by_odometry, by_velocity)};
  }

  using Found = Result<std::optional<MatchResult>>;

  [[nodiscard]] PointSet points_of(const View& view) const {
    return thin(end_points(*view.scan, view.T_base_laser),
                static_cast<float>(options_.point_spacing_m),
                static_cast<float>(options_.max_range_m));
  }

  [[nodiscard]] Found match(const PointSet& points, const SE2d& prior, const SearchWindow& window,
                            const MatchOptions& options) {
    if (auto ok = map_.focus(prior.translation()); !ok) return ok.error();
    return match_in(*matched_, points, prior, window, options, errors_);
  }

  Result<ScanOutcome> place(const PointSet& points, const Predicted& predicted,
                            const std::optional<Alternative>& alternative) {
    if (points.empty()) {
      go_to(predicted);
      return ScanOutcome();
    }
    MatchOptions options;
    options.min_score = options_.min_score;
    options.independent_points = options_.independent_points;
    options.prior_information = predicted.information;
    // It hardly changes between scans that enter the map.
    options.covariance = has_imu_ || !placed_by_match_ || map_update_due(predicted.pose);
    const Eigen::Vector3d reach = predicted.search_sigmas * predicted.sigma;
    const double half_m = std::max(reach[0], reach[1]);
    const SearchWindow window{half_m, half_m, Angle::radians(reach[2])};
    Found found = match(points, predicted.pose, window, options);
    if (coasting_) multi_start_search(points, predicted, options, found);
    const bool poor = score_of(found) < options_.tracked_score;
    if (poor) search_wider(points, predicted.pose, half_m, options, found);
    if (alternative && (poor || alternative->jumps))
      search_wider(points, alternative->pose, 0.0, options, found);
    if (!found) return found.error();
    ScanOutcome outcome;
    if (!*found) {
      go_to(predicted);
      return outcome;
    }
    pose_ = (*found)->T_map_points;
    if (options.covariance) {
      placed_ = open_direction(**found, points).widen(covariance_of(**found));
      placed_by_match_ = true;
    }
    if (has_imu_ && (*found)->covariance) fuse_match(**found, points, predicted.pose);
    outcome.score = (*found)->score;
    outcome.matched = true;
    return outcome;
  }

  /// Without a match.
  void go_to(const Predicted& predicted) {
    const Motion motion{pose_.inverse() * predicted.pose, predicted.sigma};
    placed_ = predicted.in_map ? Eigen::Matrix3d(predicted.information.inverse())
                               : motion.accumulated(placed_);
    placed_by_match_ = false;
    pose_ = predicted.pose;
  }

  static double score_of(const Found& found) { return found && *found ? (*found)->score : 0.0; }

  /// For a robot that turned more than the motion model allows, or without wheel odometry of it.
  void search_wider(const PointSet& points, const SE2d& start, double half_m, MatchOptions options,
                    Found& best) {
    constexpr double kMargin = 0.05, kPriorWeight = 0.25, kLeast_m = 0.8;
    if (!best) return;
    const double half = std::max(half_m, kLeast_m);
    *options.prior_information *= kPriorWeight;
    Found found = match_at_headings(points, start, half, options);
    const double score = score_of(found);
    if (!found || (score >= options_.lost_score && score > score_of(best) + kMargin))
      best = std::move(found);
  }

  /// The best match within 60°.
  Found match_at_headings(const PointSet& points, const SE2d& start, double half_m,
                          const MatchOptions& options) {
    constexpr int kReach_deg = 60, kStep_deg = 4;
    Found best = match(points, start, {half_m, half_m, Angle::degrees(kReach_deg)}, options);
    if (!matched_->is_local()) return best;
    for (int turn = kStep_deg; turn <= kReach_deg; turn += kStep_deg)
      for (const int side : {-1, 1}) {
        if (!best) return best;
        const SE2d turned(start.translation(),
                          start.rotation() * SO2d(Angle::degrees(side * turn)));
        Found other =
            match(points, turned, {half_m, half_m, Angle::degrees(2 * kStep_deg)}, options);
        if (!other || score_of(other) > score_of(best)) best = std::move(other);
      }
    return best;
  }

  /// After unmatched scans the filter's error may exceed the basin of convergence: matches from
  /// starts all over the filter's uncertainty, and takes the best.
  void multi_start_search(const PointSet& points, const Predicted& predicted, MatchOptions options,
                          Found& best) {
    constexpr double kStep_m = 0.5, kSigmas = 2.0, kFarthestStart_m = 3.0;
    const double sigma = std::max(predicted.sigma[0], predicted.sigma[1]);
    if (!(sigma > kStep_m)) return;
    options.prior_information.reset();
    const int reach = static_cast<int>(std::min(kFarthestStart_m, kSigmas * sigma) / kStep_m);
    const SearchWindow window{kStep_m, kStep_m, Angle::radians(kSigmas * predicted.sigma[2])};
    for (int i = -reach; i <= reach; ++i)
      for (int j = -reach; j <= reach; ++j) {
        const SE2d start(predicted.pose.translation() + kStep_m * Eigen::Vector2d(i, j),
                         predicted.pose.rotation());
        if (!best) return;
        Found found = match(points, start, window, options);
        if (!found || (*found && (!*best || (*found)->score > (*best)->score)))
          best = std::move(found);
      }
  }

  /// Along directions that the scene does not constrain the filter's pose is kept; the match is
  /// fused.
  void fuse_match(const MatchResult& match, const PointSet& points, const SE2d& predicted) {
    constexpr double kNoInformation_m =
        1000.0;  // a direction set from the filter carries no information
    const OpenDirection open = open_direction(match, points);
    if (carrier_.placed()) pose_ = open.settle(pose_, predicted);
    if (carrier_.placed() && carrier_.fuse(pose_, open.widen(*match.covariance, kNoInformation_m)))
      ++statistics_.fused_scans;
  }

  [[nodiscard]] bool map_update_due(const SE2d& pose) const {
    return !T_map_latest_inserted_ || reaches(T_map_latest_inserted_->inverse() * pose,
                                              options_.map_travel_m, options_.map_turn);
  }

  Result<void> insert_into_map(const View& view, const PointSet& points) {
    if (auto ok = map_.insert(pose_ * view.T_base_laser, *view.scan); !ok) return ok;
    if (auto ok = matched_->add(pose_, points); !ok) return ok;
    T_map_latest_inserted_ = pose_;
    uncertainty_.add(pose_, placed_);
    ++statistics_.scans_in_map;
    return {};
  }

  HectorSlamOptions options_;
  detail::CallGuard guard_;
  MultiResolutionGrid map_;
  std::unique_ptr<detail::GrowingMap> matched_;
  CarrierFilter carrier_;
  bool has_imu_ = false,
       level_known_ = false;  // inertial unit and level available at the latest scan
  bool coasting_ = false;     // the latest scan was placed by the unit alone
  PoseHistory<SE3d> motion_;  // of the base by the unit, since the latest match
  LaserScan levelled_;
  MatcherErrors errors_;  // at the latest scan
  MotionModel motion_model_;
  SE2d pose_;
  Eigen::Matrix3d placed_ = Eigen::Matrix3d::Zero();  // of the pose in the map nearby
  bool placed_by_match_ = false;                      // not by motion since
  MapUncertainty uncertainty_;
  std::optional<SE2d> T_map_latest_inserted_;  // pose of the latest scan in the map
  Trajectory trajectory_;
  HectorStatistics statistics_;
};

HectorSlamSystem::HectorSlamSystem(const HectorSlamOptions& options,
                                   const detail::MakeHectorMap& make_map)
    : engine_(detail::make_owned<Engine>(options, make_map)) {}

UpdateStatus HectorSlamSystem::add(const ImuSample& sample) { return engine_->add(sample); }
Result<ScanOutcome> HectorSlamSystem::add_scan(const LaserScan& scan,
                                               const std::optional<OdomPose>& odometry) {
  return engine_->add_scan(scan, detail::raw(odometry));
}
const Trajectory& HectorSlamSystem::trajectory() const { return engine_->trajectory(); }
Eigen::Matrix3d HectorSlamSystem::covariance() const { return engine_->covariance(); }
const OccupancyGrid& HectorSlamSystem::map() const { return engine_->map(); }
std::size_t HectorSlamSystem::memory_bytes() const { return engine_->memory_bytes(); }
const HectorStatistics& HectorSlamSystem::statistics() const { return engine_->statistics(); }
const CarrierFilter& HectorSlamSystem::carrier() const { return engine_->carrier(); }

}  // namespace wayfare
