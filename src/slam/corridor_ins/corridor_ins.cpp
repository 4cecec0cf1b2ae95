#include <wayfare/system/corridor_ins.hpp>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <wayfare/eval/chi_square.hpp>

#include "motion_watch.hpp"
#include "wall_states.hpp"

namespace wayfare {
namespace {

using namespace corridor_state;
using corridor::Filter;
using Row = Eigen::Matrix<double, 1, kSize>;

Filter start_filter(const CorridorInsOptions& o, const SE2d& start) {
  CorridorVector x = CorridorVector::Zero(), sigma = CorridorVector::Constant(1.0);
  x[kX] = start.x(), x[kY] = start.y(), x[kHeading] = start.heading().radians();
  x[kBiasConstant] = o.start_bias_value_rad_s;
  sigma[kX] = sigma[kY] = o.start_position_m;
  sigma[kHeading] = o.start_heading_rad;
  sigma[kSpeed] = sigma[kSpeedX] = sigma[kSpeedY] = 1e-6;
  sigma[kAcceleration] = o.noise.acceleration_sigma_m_s2;
  sigma[kBiasWalk] = o.noise.bias_sigma_rad_s;
  sigma[kBiasConstant] = o.start_bias_rad_s;
  sigma[kBiasDrift] = o.start_drift_rad_s2;
  sigma[kScale] = o.start_scale;
  return {x, sigma.cwiseAbs2().asDiagonal()};
}

}  // namespace

class CorridorIns::Engine {
 public:
  Engine(const CorridorInsOptions& options, const SE2d& start)
      : options_(options),
        filter_(start_filter(options, start)),
        process_(options.noise),
        watch_(options),
        detector_(detector_options(options)),
        walls_(options.T_base_laser.raw()) {
    for (int dof = 1; dof <= 3; ++dof)
      gates_[dof] = eval::chi_square_quantile(1.0 - options.gate_probability, dof);
  }

  Result<void> add_motion(const MotionSample& s) {
    if (!std::isfinite(s.turn_rate_rad_s) || !std::isfinite(s.speed_m_s)) {
      ++report_.refused_samples;
      return Error{ErrorCode::invalid, "a motion sample is not finite", {}};
    }
    if (time_ && s.time <= *time_) {
      ++report_.refused_samples;
      return Error{ErrorCode::invalid, "a motion sample is not after the one before", {}};
    }
    // The first sample says when things begin: what it tells of was before.
    if (time_) step(s, s.time - *time_);
    time_ = s.time;
    return {};
  }

  Result<CorridorScanUpdate> add_scan(const LaserScan& scan) {
    if (scan_time_ && scan.time <= *scan_time_)
      return Error{ErrorCode::invalid, "a scan is not after the one before", {}};
    if (!scan_time_) walls_time_ = scan.time;
    scan_time_ = scan.time;
    ++report_.scans;
    CorridorScanUpdate update;
    if (!options_.use_walls) return update;
    const corridor::Predicted predicted = walls_.predict(filter_);
    see(scan, predicted, update);
    if (update.walls) {
      take(predicted, update);
      walls_time_ = scan.time;
    } else {
      report_.longest_outage = std::max(report_.longest_outage, scan.time - walls_time_);
      if (options_.memory == WallMemory::one_scan) walls_.forget_walls(), walls_.forget_end();
    }
    return update;
  }

  [[nodiscard]] const Filter& filter() const { return filter_; }
  [[nodiscard]] const CorridorReport& report() const { return report_; }

 private:
  static WallOptions detector_options(const CorridorInsOptions& o) {
    WallOptions walls = o.walls;
    walls.end_walls = o.use_end_walls;
    return walls;
  }

  void say(LogTime time, std::string what) {
    if (report_.events.size() < 100) report_.events.push_back({time, std::move(what)});
  }

  void step(const MotionSample& s, Duration dt) {
    const auto judged = watch_.judge(s, dt);
    report_.saturated_samples += judged.saturated ? 1 : 0;
    report_.slipping_samples += judged.slipping ? 1 : 0;
    if (judged.saturated && !saturated_) say(s.time, "gyro beyond its range");
    if (judged.slip_began) say(s.time, "wheels slip");
    saturated_ = judged.saturated;
    filter_.predict(process_, judged.input);
    if (judged.input.at_rest) calibrate_at_rest(judged.input);
  }

  /// All a gyro reads while the wheels stand is bias and noise.
  void calibrate_at_rest(const CorridorInput& u) {
    ++report_.rest_samples;
    Row row = Row::Zero();
    row[kBiasWalk] = row[kBiasConstant] = 1.0;
    const double walk = options_.noise.angle_random_walk_rad_per_sqrt_s;
    const double bias = filter_.state()[kBiasWalk] + filter_.state()[kBiasConstant];
    filter_.update(
        [&](const CorridorVector&) {
          return ScalarMeasurement<double, Row>{u.turn_rate_rad_s - bias, row,
                                                walk * walk / u.dt_s};
        },
        6.0);
  }

  /// Tracking where there is something to track, else, or where that fails, acquisition.
  void see(const LaserScan& scan, const corridor::Predicted& predicted,
           CorridorScanUpdate& update) {
    if (walls_.has_walls() && rejections_ < options_.rejections_to_reacquire) {
      update.walls = detector_.track(scan, predicted.walls);
      update.tracked = update.walls.has_value();
    }
    if (update.tracked) {
      ++report_.tracked;
      look_for_more(scan, predicted, update);
    } else {
      update.walls = detector_.acquire(scan);
      report_.acquisitions += update.walls ? 1 : 0;
      if (update.walls && walls_.has_walls())
        update.walls = corridor::facing(*update.walls, predicted.walls.direction);
    }
    if (update.walls) roughen(*update.walls);
    report_.scans_with_walls += update.walls ? 1 : 0;
    report_.not_parallel += update.walls && !update.walls->parallel ? 1 : 0;
  }

  void roughen(CorridorWalls& walls) const {
    const double turn2 = options_.wall_direction_sigma_rad * options_.wall_direction_sigma_rad;
    const double offset2 = options_.wall_offset_sigma_m * options_.wall_offset_sigma_m;
    walls.covariance.diagonal() += Eigen::Vector3d(turn2, offset2, offset2);
    if (walls.end) walls.end->covariance.diagonal() += Eigen::Vector2d(offset2, turn2);
  }

  /// From time to time: the other wall, or one across, may have come into view.
  void look_for_more(const LaserScan& scan, const corridor::Predicted& predicted,
                     CorridorScanUpdate& update) {
    constexpr int kEvery = 5;
    const bool one_side = !predicted.walls.left || !predicted.walls.right;
    const bool no_end = options_.use_end_walls && !predicted.walls.end;
    if ((!one_side && !no_end) || report_.scans % kEvery != 0) return;
    const auto found = detector_.acquire(scan, predicted.walls.direction);
    if (!found) return;
    if (no_end && found->end) update.walls->end = found->end;
    if (one_side && !predicted.walls.left) update.walls->left = found->left;
    if (one_side && !predicted.walls.right) update.walls->right = found->right;
    for (const int k : {1, 2}) {
      const bool new_side = k == 1 ? !predicted.walls.left : !predicted.walls.right;
      if (new_side) update.walls->covariance(k, k) = found->covariance(k, k);
    }
  }

  void take(const corridor::Predicted& predicted, CorridorScanUpdate& update) {
    const CorridorWalls& seen = *update.walls;
    const bool lost = scan_time_ && *scan_time_ - walls_time_ > options_.lost_after;
    const bool same = walls_.has_walls() && use_sides(predicted, seen);
    if (same) {
      rejections_ = 0;
      update.outcome = WallOutcome::used;
      ++report_.scans_used;
      walls_.enter_missing_side(seen, filter_);
    } else if (!walls_.has_walls() || lost || rejections_ >= options_.rejections_to_reacquire) {
      begin_corridor(seen, update);
    } else {
      ++rejections_;
      ++report_.refused_walls;
      update.outcome = WallOutcome::refused;
      if (rejections_ == 1) say(*scan_time_, "walls are not where they should be");
    }
    if (options_.use_end_walls) update.end_used = take_end(predicted, seen, update);
    if (options_.memory == WallMemory::one_scan) remember_this_scan(seen);
  }

  void begin_corridor(const CorridorWalls& seen, CorridorScanUpdate& update) {
    rejections_ = 0;
    ++report_.corridors;
    update.outcome = WallOutcome::reacquired;
    walls_.enter(seen, filter_);
    if (options_.memory == WallMemory::corridor) say(*scan_time_, "walls acquired");
    if (options_.square_sigma_rad > 0.0) set_square(seen);
  }

  /// New walls at right angles to the first ones, or along them, where they nearly are.
  void set_square(const CorridorWalls& seen) {
    constexpr double kNearly_rad = 0.2, kLong_m = 2.0;
    const auto is_long = [](const auto& wall) {
      return wall && wall->end_m - wall->begin_m > kLong_m;
    };
    if (!is_long(seen.left) && !is_long(seen.right)) return;
    const double direction = filter_.state()[kDirection];
    if (!first_direction_rad_) first_direction_rad_ = direction;
    const double off = std::remainder(direction - *first_direction_rad_, 0.5 * std::numbers::pi);
    if (std::abs(off) > kNearly_rad) return;
    Row row = Row::Zero();
    row[kDirection] = 1.0;
    filter_.update([&](const CorridorVector&) {
      return ScalarMeasurement<double, Row>{-off, row,
                                            options_.square_sigma_rad * options_.square_sigma_rad};
    });
  }

  void remember_this_scan(const CorridorWalls& seen) {
    walls_.enter(seen, filter_);
    if (seen.end && options_.use_end_walls) {
      walls_.enter_end(*seen.end, filter_);
    } else {
      walls_.forget_end();
    }
  }

  /// Direction and both offsets at once; where that is refused, with one side and with the other.
  bool use_sides(const corridor::Predicted& p, const CorridorWalls& seen) {
    const bool left = p.walls.left && seen.left, right = p.walls.right && seen.right;
    if (!left && !right) return false;
    if (use_rows(p, seen, left, right)) return true;
    if (!left || !right) return false;
    const bool one = use_rows(p, seen, true, false) || use_rows(p, seen, false, true);
    report_.refused_sides += one ? 1 : 0;
    return one;
  }

  bool use_rows(const corridor::Predicted& p, const CorridorWalls& seen, bool left, bool right) {
    Eigen::Vector3d all(wrap_to_pi((seen.direction - p.walls.direction).radians()), 0.0, 0.0);
    if (left) all[1] = seen.left->offset_m - p.walls.left->offset_m;
    if (right) all[2] = seen.right->offset_m - p.walls.right->offset_m;
    std::vector<int> rows{0};
    if (left) rows.push_back(1);
    if (right) rows.push_back(2);
    const auto n = static_cast<Eigen::Index>(rows.size());
    Eigen::VectorXd innovation = all(rows);
    corridor::Rows h = p.rows(rows, Eigen::all);
    Eigen::MatrixXd r = seen.covariance(rows, rows);
    return filter_.update_block<Eigen::Dynamic>(innovation, h, r, gates_[n]);
  }

  /// Behind a corner the wall that stood across stands beside, one of the two: the same points must
  /// not count twice.
  static bool stands_along(const corridor::Predicted& p, const CorridorWalls& seen) {
    constexpr double kAcross_rad = 0.5;
    if (!p.walls.end) return false;
    const double off = (p.walls.end->alpha - seen.direction).radians();
    return std::abs(std::remainder(off, std::numbers::pi)) > kAcross_rad;
  }

  bool take_end(const corridor::Predicted& p, const CorridorWalls& seen,
                const CorridorScanUpdate& update) {
    if (stands_along(p, seen)) walls_.forget_end();
    if (!seen.end || update.outcome == WallOutcome::refused || stands_along(p, seen)) return false;
    if (p.walls.end) {
      const Eigen::Vector2d innovation(wrap_to_pi((seen.end->alpha - p.walls.end->alpha).radians()),
                                       seen.end->rho_m - p.walls.end->rho_m);
      Eigen::Matrix2d r;
      r << seen.end->covariance(1, 1), seen.end->covariance(0, 1), seen.end->covariance(0, 1),
          seen.end->covariance(0, 0);
      if (filter_.update_block<2>(innovation, p.end_rows, r, gates_[2])) {
        end_rejections_ = 0;
        ++report_.end_walls_used;
        return true;
      }
      ++report_.refused_end_walls;
      if (++end_rejections_ < options_.rejections_to_reacquire) return false;
    }
    end_rejections_ = 0;
    walls_.enter_end(*seen.end, filter_);
    return false;
  }

  CorridorInsOptions options_;
  Filter filter_;
  CorridorMotion process_;
  corridor::MotionWatch watch_;
  WallDetector detector_;
  corridor::WallStates walls_;
  CorridorReport report_;
  double gates_[4] = {};
  std::optional<LogTime> time_, scan_time_;
  std::optional<double> first_direction_rad_;
  LogTime walls_time_;
  int rejections_ = 0, end_rejections_ = 0;
  bool saturated_ = false;
};

CorridorIns::CorridorIns(const CorridorInsOptions& options, const SE2d& start)
    : engine_(std::make_unique<Engine>(options, start)) {}
CorridorIns::~CorridorIns() = default;
CorridorIns::CorridorIns(CorridorIns&&) noexcept = default;
CorridorIns& CorridorIns::operator=(CorridorIns&&) noexcept = default;

Result<void> CorridorIns::add_motion(const MotionSample& sample) {
  return engine_->add_motion(sample);
}
Result<CorridorScanUpdate> CorridorIns::add_scan(const LaserScan& scan) {
  return engine_->add_scan(scan);
}

const CorridorVector& CorridorIns::state() const { return engine_->filter().state(); }
const CorridorMatrix& CorridorIns::covariance() const { return engine_->filter().covariance(); }
const CorridorReport& CorridorIns::report() const { return engine_->report(); }

SE2d CorridorIns::pose() const {
  return SE2d(state()[kX], state()[kY], Angle::radians(state()[kHeading]));
}

Eigen::Matrix3d CorridorIns::pose_covariance() const {
  const std::array<int, 3> at{kX, kY, kHeading};
  return covariance()(at, at);
}

Eigen::Matrix<double, 5, 5> CorridorIns::joint_covariance() const {
  Eigen::Matrix<double, 5, kSize> pick = Eigen::Matrix<double, 5, kSize>::Zero();
  pick(0, kX) = pick(1, kY) = pick(2, kHeading) = pick(4, kScale) = 1.0;
  pick(3, kBiasWalk) = pick(3, kBiasConstant) = 1.0;
  return pick * covariance() * pick.transpose();
}
Estimate CorridorIns::gyro_bias() const {
  const CorridorMatrix& p = covariance();
  return {state()[kBiasWalk] + state()[kBiasConstant],
          std::sqrt(p(kBiasWalk, kBiasWalk) + p(kBiasConstant, kBiasConstant) +
                    2.0 * p(kBiasWalk, kBiasConstant))};
}
Estimate CorridorIns::gyro_drift() const {
  return {state()[kBiasDrift], std::sqrt(covariance()(kBiasDrift, kBiasDrift))};
}
Estimate CorridorIns::speed_scale() const {
  return {state()[kScale], std::sqrt(covariance()(kScale, kScale))};
}

}  // namespace wayfare
