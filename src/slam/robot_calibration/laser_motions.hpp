#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/match/registration.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/robot_calibration.hpp>
#include <wayfare/sync/scan_deskewer.hpp>

namespace wayfare::calibration {

/// Motion of the laser between two scans, in its own frame.
struct LaserMotion {
  double from_s = 0.0, to_s = 0.0;
  SE2d T_from_to;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
};

struct LaserMotions {
  std::vector<LaserMotion> coarse;  ///< of a given least size, for the mounting
  std::vector<LaserMotion> fine;    ///< from scan to scan
  std::size_t scans = 0, unmatched = 0;
};

/// Matches each scan to those of the last few poses. The prior is the last motion continued: no
/// odometry, whose errors are to be found.
class LaserOdometry {
 public:
  explicit LaserOdometry(const RobotCalibrationOptions& options) : o_(options) {}

  void add(double time_s, const PointSet& all) {
    ++motions_.scans;
    const PointSet points = thin(all, 0.03F, 30.0F);
    if (points.size() < 30) return lose();
    if (map_.empty()) return begin(time_s, points);
    const auto matched = match(time_s, points);
    if (!matched) {
      lose();
      return begin(time_s, points);
    }
    record(time_s, *matched, points);
  }
  [[nodiscard]] LaserMotions take() { return std::move(motions_); }

 private:
  struct Placed {
    double time_s;
    SE2d T_map_laser;
    Eigen::Matrix3d covariance;
  };
  static constexpr std::size_t kScans = 8;

  void lose() {
    if (!map_.empty()) ++motions_.unmatched;
    map_.clear(), placed_.clear(), last_.reset(), before_.reset(), key_.reset();
  }
  void begin(double time_s, const PointSet& points) {
    last_ = key_ = Placed{time_s, SE2d(), Eigen::Matrix3d::Zero()};
    add_to_map(SE2d(), points);
  }
  void add_to_map(const SE2d& pose, const PointSet& points) {
    map_.push_back(points), placed_.push_back(pose);
    if (map_.size() > kScans) map_.pop_front(), placed_.pop_front();
    std::vector<PlacedPoints> scans;
    for (std::size_t i = 0; i < map_.size(); ++i) scans.push_back({&map_[i], placed_[i]});
    auto made = matcher_.make_map(scans);
    if (made) surface_ = *std::move(made);
  }
  [[nodiscard]] std::optional<Placed> match(double time_s, const PointSet& points) const {
    SE2d prior = last_->T_map_laser;
    if (before_) {
      const Eigen::Vector3d step = last_->T_map_laser.minus(before_->T_map_laser);
      const double dt = last_->time_s - before_->time_s;
      if (dt > 0.0) prior = prior.plus(std::min((time_s - last_->time_s) / dt, 2.0) * step);
    }
    MatchOptions options;
    options.min_score = 0.6;
    options.covariance = true;
    options.independent_points = 100.0;
    const auto found =
        matcher_.match(surface_, points, prior, {0.5, 0.5, Angle::degrees(30.0)}, options);
    if (!found || !*found) return std::nullopt;
    return Placed{time_s, (*found)->T_map_points, *(*found)->covariance};
  }
  static LaserMotion motion(const Placed& a, const Placed& b) {
    // Both poses have errors against the map.
    return {a.time_s, b.time_s, a.T_map_laser.inverse() * b.T_map_laser, 2.0 * b.covariance};
  }
  void record(double time_s, const Placed& now, const PointSet& points) {
    if (time_s - last_->time_s < 1.0) motions_.fine.push_back(motion(*last_, now));
    const LaserMotion from_key = motion(*key_, now);
    const bool moved = from_key.T_from_to.translation().norm() > o_.motion_m ||
                       std::abs(from_key.T_from_to.heading().radians()) > o_.motion_turn.radians();
    before_ = last_, last_ = now;
    const double since = time_s - key_->time_s;
    if (!moved && since < kLongest_s) return;
    if (since < 2.0 * kLongest_s) motions_.coarse.push_back(from_key);
    key_ = now;
    if (moved) add_to_map(now.T_map_laser, points);
  }

  static constexpr double kLongest_s = 2.0;
  const RobotCalibrationOptions& o_;
  IcpMatcher matcher_{{.sigma_m = 0.03}};
  std::deque<PointSet> map_;
  std::deque<SE2d> placed_;
  SurfaceMap surface_;
  std::optional<Placed> last_, before_, key_;
  LaserMotions motions_;
};

}  // namespace wayfare::calibration
