#include <wayfare/system/hector_slam.hpp>

#include <cmath>
#include <utility>

#include <wayfare/measure/point_set.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "../motion.hpp"
#include "../scan_check.hpp"

namespace wayfare {

class HectorSlam::Engine {
 public:
  explicit Engine(const HectorSlamOptions& options)
      : options_(options),
        map_(options.map),
        matcher_(options.match),
        motion_model_(options.odometry, options.constant_velocity) {}

  Result<ScanOutcome> add_scan(const LaserScan& scan, const std::optional<SE2d>& odometry) {
    const auto last = trajectory_.empty() ? std::nullopt : std::optional(trajectory_.back().time);
    if (auto ok = detail::check_scan(scan, odometry, last); !ok) return ok.error();
    ScanOutcome outcome;
    if (map_.empty()) {
      pose_ = odometry.value_or(SE2d());
      outcome.matched = true;
    } else {
      outcome = place(scan, motion_model_.predict(scan.time, odometry));
    }
    if (outcome.matched && due()) {
      if (auto ok = put_into_map(scan); !ok) return ok.error();
      outcome.became_node = true;
    }
    motion_model_.tell(scan.time, pose_, odometry);
    outcome.T_map_base = Transform2<frame::Map, frame::Base>(pose_);
    trajectory_.push_back({scan.time, outcome.T_map_base});
    ++statistics_.scans;
    statistics_.unmatched_scans += outcome.matched ? 0 : 1;
    return outcome;
  }

  [[nodiscard]] const Trajectory& trajectory() const { return trajectory_; }
  [[nodiscard]] const OccupancyGrid& map() const { return map_.finest(); }
  [[nodiscard]] const HectorStatistics& statistics() const { return statistics_; }

 private:
  ScanOutcome place(const LaserScan& scan, const Motion& motion) {
    const SE2d expected = pose_ * motion.increment;
    const PointSet points = thin(end_points(scan, options_.T_base_laser.raw()),
                                 static_cast<float>(options_.point_spacing_m),
                                 static_cast<float>(options_.max_range_m));
    MatchOptions match;
    match.min_score = options_.least_score;
    match.independent_points = options_.independent_points;
    match.prior_information = Eigen::Matrix3d(motion.sigma.cwiseAbs2().cwiseInverse().asDiagonal());
    const Eigen::Vector3d reach = options_.search_sigmas * motion.sigma;
    const double half_m = std::max(reach[0], reach[1]);
    const SearchWindow window{half_m, half_m, Angle::radians(reach[2])};
    ScanOutcome outcome;
    pose_ = expected;
    if (points.empty()) return outcome;
    const auto found = matcher_.match(map_.tables(), points, expected, window, match);
    if (!found || !*found) return outcome;
    pose_ = (*found)->T_map_points;
    outcome.score = (*found)->score;
    outcome.matched = true;
    return outcome;
  }

  [[nodiscard]] bool due() const {
    if (!in_map_) return true;
    const SE2d moved = in_map_->inverse() * pose_;
    return moved.translation().norm() >= options_.map_travel_m ||
           std::abs(moved.heading().radians()) >= options_.map_turn.radians();
  }

  Result<void> put_into_map(const LaserScan& scan) {
    if (auto ok = map_.insert(pose_ * options_.T_base_laser.raw(), scan); !ok) return ok;
    in_map_ = pose_;
    ++statistics_.scans_in_map;
    return {};
  }

  HectorSlamOptions options_;
  MultiResolutionGrid map_;
  GaussNewtonMatcher matcher_;
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

}  // namespace wayfare
