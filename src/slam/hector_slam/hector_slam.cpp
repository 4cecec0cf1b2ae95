#include <wayfare/slam/hector_slam.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "match/local/registration.hpp"
#include "match/open_direction.hpp"
#include "slam/motion.hpp"
#include "slam/scan_check.hpp"

namespace wayfare {

class HectorSlam::Engine {
 public:
  explicit Engine(const HectorSlamOptions& options)
      : options_(options),
        map_(options.map),
        matcher_(options.match),
        carrier_(options.carrier),
        motion_model_(options.odometry, options.constant_velocity) {}

  UpdateStatus add(const ImuSample& s) {
    const UpdateStatus status = carrier_.add({s.time, options_.q_base_unit * s.angular_rate_radps,
                                              options_.q_base_unit * s.specific_force_mps2});
    statistics_.carrier_starts = carrier_.starts();
    return status;
  }

  Result<ScanOutcome> add_scan(const LaserScan& scan, const std::optional<SE2d>& odometry) {
    const auto last = trajectory_.empty() ? std::nullopt : std::optional(trajectory_.back().time);
    if (auto ok = detail::check_scan(scan, odometry, last); !ok) return ok.error();
    carried_ = carrier_.tells_of(scan.time);
    if (carried_) carrier_.advance(scan.time);
    level_known_ = carried_ && carrier_.level_sigma() < options_.level_sigma;
    const Sight sight = level_known_ ? level(scan) : Sight{&scan, options_.T_base_laser.raw()};
    ScanOutcome outcome;
    if (map_.empty()) {
      pose_ = odometry.value_or(SE2d());
      outcome.matched = true;
    } else {
      outcome = place(sight, expect(scan.time, odometry), beside_odometry(scan.time, odometry));
    }
    if (carried_ && !carrier_.placed())
      carrier_.place(pose_, options_.least_sigma_m, options_.least_sigma);
    if (outcome.matched && due()) {
      if (auto ok = put_into_map(sight); !ok) return ok.error();
      outcome.became_node = true;
    }
    motion_model_.tell(scan.time, pose_, odometry);
    coasting_ = carried_ && !outcome.matched;
    outcome.T_map_base = Transform2<frame::Map, frame::Base>(pose_);
    trajectory_.push_back({scan.time, outcome.T_map_base});
    ++statistics_.scans;
    statistics_.unmatched_scans += outcome.matched ? 0 : 1;
    return outcome;
  }

  [[nodiscard]] const Trajectory& trajectory() const { return trajectory_; }
  [[nodiscard]] const OccupancyGrid& map() const { return map_.finest(); }
  [[nodiscard]] const HectorStatistics& statistics() const { return statistics_; }
  [[nodiscard]] const CarrierFilter& carrier() const { return carrier_; }

 private:
  /// A scan and where it was taken from.
  struct Sight {
    const LaserScan* scan;
    SE2d T_base_laser;
  };
  /// Where the robot should be, and what is known of that in the pose's own axes.
  struct Expected {
    SE2d pose;
    Eigen::Vector3d sigma;
    Eigen::Matrix3d information;
  };

  /// The scan turned level, its x axis along the heading.
  Sight level(const LaserScan& scan) {
    const SE2d& mounted = options_.T_base_laser.raw();
    const SO3d q = carrier_.q_level_body();
    const SO3d q_base_laser =
        SO3d::exp(Eigen::Vector3d(0, 0, mounted.rotation().angle().radians()));
    levelled_ = level_scan(scan, q * q_base_laser, options_.level);
    ++statistics_.levelled_scans;
    const Eigen::Vector3d at(mounted.x(), mounted.y(), 0);
    return {&levelled_, SE2d(Eigen::Vector2d((q * at).head<2>()), SO2d())};
  }

  [[nodiscard]] Expected expect(LogTime time, const std::optional<SE2d>& odometry) const {
    const Motion motion = motion_model_.predict(time, odometry);
    if (!(level_known_ && carrier_.placed()) || odometry)
      return {pose_ * motion.increment, motion.sigma,
              Eigen::Matrix3d(motion.sigma.cwiseAbs2().cwiseInverse().asDiagonal())};
    Eigen::Matrix3d p = carrier_.planar_covariance();
    p.diagonal() += Eigen::Vector3d(options_.least_sigma_m, options_.least_sigma_m,
                                    options_.least_sigma.radians())
                        .cwiseAbs2();
    return {carrier_.planar(), p.diagonal().cwiseSqrt(), p.inverse()};
  }

  /// Where the robot gets by going on as it did, where odometry has it elsewhere.
  struct Beside {
    SE2d pose;
    bool leaps;  ///< far elsewhere
  };
  [[nodiscard]] std::optional<Beside> beside_odometry(LogTime time,
                                                      const std::optional<SE2d>& odometry) const {
    if (!odometry) return std::nullopt;
    const Motion by_odometry = motion_model_.predict(time, odometry);
    const Motion going_on = motion_model_.predict(time, {});
    if (!contradicts(by_odometry, going_on, options_.search_sigmas)) return std::nullopt;
    return Beside{pose_ * going_on.increment, leaps(by_odometry, going_on)};
  }

  ScanOutcome place(const Sight& sight, const Expected& expected,
                    const std::optional<Beside>& beside) {
    const PointSet points = thin(end_points(*sight.scan, sight.T_base_laser),
                                 static_cast<float>(options_.point_spacing_m),
                                 static_cast<float>(options_.max_range_m));
    MatchOptions match;
    match.min_score = options_.least_score;
    match.independent_points = options_.independent_points;
    match.prior_information = expected.information;
    match.covariance = carried_;
    const Eigen::Vector3d reach = options_.search_sigmas * expected.sigma;
    const double half_m = std::max(reach[0], reach[1]);
    const SearchWindow window{half_m, half_m, Angle::radians(reach[2])};
    ScanOutcome outcome;
    pose_ = expected.pose;
    if (points.empty()) return outcome;
    auto found = matcher_.match(map_.tables(), points, expected.pose, window, match);
    if (coasting_) multi_start_search(points, expected, match, found);
    const bool poor = score_of(found) < options_.tracked_score;
    if (poor) look_wider(points, expected.pose, half_m, match, found);
    if (beside && (poor || beside->leaps)) look_wider(points, beside->pose, 0.0, match, found);
    if (!found || !*found) return outcome;
    pose_ = (*found)->T_map_points;
    if ((*found)->covariance) settle(**found, points, expected.pose);
    outcome.score = (*found)->score;
    outcome.matched = true;
    return outcome;
  }

  static double score_of(const Result<std::optional<MatchResult>>& found) {
    return found && *found ? (*found)->score : 0.0;
  }

  /// A robot that turned farther than motion should err, or whose wheels said nothing of it.
  void look_wider(const PointSet& points, const SE2d& start, double half_m, MatchOptions match,
                  Result<std::optional<MatchResult>>& best) const {
    constexpr double kClearly = 0.05, kLooser = 0.25, kLeast_m = 0.8;
    const double half = std::max(half_m, kLeast_m);
    *match.prior_information *= kLooser;
    auto found =
        matcher_.match(map_.tables(), points, start, {half, half, Angle::degrees(60)}, match);
    const double score = score_of(found);
    if (score >= options_.lost_score && score > score_of(best) + kClearly) best = std::move(found);
  }

  /// After scans that saw nothing the filter may be farther off than a climb leads back: climbs
  /// from all over what it allows, and the best of them.
  void multi_start_search(const PointSet& points, const Expected& expected, MatchOptions match,
                          Result<std::optional<MatchResult>>& best) const {
    constexpr double kStep_m = 0.5, kSigmas = 2.0, kFarthest_m = 3.0;
    const double sigma = std::max(expected.sigma[0], expected.sigma[1]);
    if (!(sigma > kStep_m)) return;
    match.prior_information.reset();
    const int reach = static_cast<int>(std::min(kFarthest_m, kSigmas * sigma) / kStep_m);
    const SearchWindow window{kStep_m, kStep_m, Angle::radians(kSigmas * expected.sigma[2])};
    for (int i = -reach; i <= reach; ++i)
      for (int j = -reach; j <= reach; ++j) {
        const SE2d start(expected.pose.translation() + kStep_m * Eigen::Vector2d(i, j),
                         expected.pose.rotation());
        auto found = matcher_.match(map_.tables(), points, start, window, match);
        if (!found || !*found) continue;
        if (!best || !*best || (*found)->score > (*best)->score) best = std::move(found);
      }
  }

  /// Along what the scene leaves open the filter leads; the match enters it.
  void settle(const MatchResult& match, const PointSet& points, const SE2d& expected) {
    constexpr double kNothing_m = 1000.0;  // what was settled by the filter is no news to it
    const OpenDirection open(*match.constraint, detail::rms_distance_m(points));
    if (carrier_.placed()) pose_ = open.settle(pose_, expected);
    if (carrier_.placed() && carrier_.fuse(pose_, open.widen(*match.covariance, kNothing_m)))
      ++statistics_.fused_scans;
  }

  [[nodiscard]] bool due() const {
    if (!in_map_) return true;
    const SE2d moved = in_map_->inverse() * pose_;
    return moved.translation().norm() >= options_.map_travel_m ||
           std::abs(moved.heading().radians()) >= options_.map_turn.radians();
  }

  Result<void> put_into_map(const Sight& sight) {
    if (auto ok = map_.insert(pose_ * sight.T_base_laser, *sight.scan); !ok) return ok;
    in_map_ = pose_;
    ++statistics_.scans_in_map;
    return {};
  }

  HectorSlamOptions options_;
  MultiResolutionGrid map_;
  GaussNewtonMatcher matcher_;
  CarrierFilter carrier_;
  bool carried_ = false, level_known_ = false;  // by the unit, at the latest scan
  bool coasting_ = false;                       // … which had a unit alone
  LaserScan levelled_;
  MotionModel motion_model_;
  SE2d pose_;
  std::optional<SE2d> in_map_;  // where the latest scan in the map was taken
  Trajectory trajectory_;
  HectorStatistics statistics_;
};

HectorSlam::HectorSlam(const HectorSlamOptions& options)
    : engine_(std::make_unique<Engine>(options)) {}
HectorSlam::~HectorSlam() = default;
HectorSlam::HectorSlam(HectorSlam&&) noexcept = default;
HectorSlam& HectorSlam::operator=(HectorSlam&&) noexcept = default;

Result<ScanOutcome> HectorSlam::add_scan(
    const LaserScan& scan, const std::optional<Transform2<frame::Odom, frame::Base>>& odometry) {
  return engine_->add_scan(scan, odometry ? std::optional(odometry->raw()) : std::nullopt);
}
const Trajectory& HectorSlam::trajectory() const { return engine_->trajectory(); }
const OccupancyGrid& HectorSlam::map() const { return engine_->map(); }
const HectorStatistics& HectorSlam::statistics() const { return engine_->statistics(); }
const CarrierFilter& HectorSlam::carrier() const { return engine_->carrier(); }
UpdateStatus HectorSlam::add(const ImuSample& sample) { return engine_->add(sample); }

}  // namespace wayfare
