#include "nav/corridor_ins/engine.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <wayfare/core/statistics.hpp>

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

WallOptions detector_options(const CorridorInsOptions& o) {
  WallOptions walls = o.walls;
  walls.end_walls = o.use_end_walls;
  return walls;
}

}  // namespace

CorridorIns::Engine::Engine(const CorridorInsOptions& options, const SE2d& start)
    : options_(options),
      filter_(start_filter(options, start)),
      process_(options.noise),
      watch_(options),
      detector_(detector_options(options)),
      walls_(options.T_base_laser.raw()) {
  for (int dof = 1; dof <= 3; ++dof)
    gates_[dof] = chi_square_quantile(1.0 - options.gate_probability, dof);
}

Result<void> CorridorIns::Engine::add_motion(const MotionSample& s) {
  if (!std::isfinite(s.turn_rate_rad_s) || !std::isfinite(s.speed_m_s)) {
    ++report_.refused_samples;
    return Error{ErrorCode::invalid, "a motion sample is not finite", {}};
  }
  if (time_ && s.time <= *time_) {
    ++report_.refused_samples;
    return Error{ErrorCode::invalid, "a motion sample is not after the previous one", {}};
  }
  // The first sample only gives the start time.
  if (time_) step(s, s.time - *time_);
  time_ = s.time;
  return {};
}

Result<CorridorScanUpdate> CorridorIns::Engine::add_scan(const LaserScan& scan) {
  if (scan_time_ && scan.time <= *scan_time_)
    return Error{ErrorCode::invalid, "a scan is not after the previous one", {}};
  if (!scan_time_) walls_time_ = scan.time;
  scan_time_ = scan.time;
  ++report_.scans;
  CorridorScanUpdate update;
  if (!options_.use_walls) return update;
  const corridor::Predicted predicted = walls_.predict(filter_);
  detect_walls(scan, predicted, update);
  if (update.walls) {
    use_walls(predicted, update);
    walls_time_ = scan.time;
  } else {
    report_.longest_outage = std::max(report_.longest_outage, scan.time - walls_time_);
    if (options_.memory == WallMemory::one_scan) walls_.forget_walls(), walls_.forget_end();
  }
  return update;
}

void CorridorIns::Engine::log_event(LogTime time, std::string what) {
  if (report_.events.size() < 100) report_.events.push_back({time, std::move(what)});
}

void CorridorIns::Engine::step(const MotionSample& s, Duration dt) {
  const auto checked = watch_.check(s, dt);
  report_.saturated_samples += checked.saturated ? 1 : 0;
  report_.slipping_samples += checked.slipping ? 1 : 0;
  if (checked.saturated && !saturated_) log_event(s.time, "gyro beyond its range");
  if (checked.slip_began) log_event(s.time, "wheels slip");
  saturated_ = checked.saturated;
  filter_.predict(process_, checked.input);
  if (checked.input.at_rest) calibrate_at_rest(checked.input);
}

void CorridorIns::Engine::calibrate_at_rest(const CorridorInput& u) {
  ++report_.rest_samples;
  Row row = Row::Zero();
  row[kBiasWalk] = row[kBiasConstant] = 1.0;
  const double walk = options_.noise.angle_random_walk_rad_per_sqrt_s;
  const double bias = filter_.state()[kBiasWalk] + filter_.state()[kBiasConstant];
  filter_.update(
      [&](const CorridorVector&) {
        return ScalarMeasurement<double, Row>{u.turn_rate_rad_s - bias, row, walk * walk / u.dt_s};
      },
      6.0);
}

void CorridorIns::Engine::detect_walls(const LaserScan& scan, const corridor::Predicted& predicted,
                                       CorridorScanUpdate& update) {
  if (walls_.has_walls() && rejections_ < options_.rejections_to_reacquire) {
    update.walls = detector_.track(scan, predicted.walls);
    update.tracked = update.walls.has_value();
  }
  if (update.tracked) {
    ++report_.tracked;
    search_missing_walls(scan, predicted, update);
  } else {
    update.walls = detector_.acquire(scan);
    report_.acquisitions += update.walls ? 1 : 0;
    if (update.walls && walls_.has_walls())
      update.walls = corridor::facing(*update.walls, predicted.walls.direction);
  }
  if (update.walls) add_wall_noise(*update.walls);
  report_.scans_with_walls += update.walls ? 1 : 0;
  report_.not_parallel += update.walls && !update.walls->parallel ? 1 : 0;
}

void CorridorIns::Engine::add_wall_noise(CorridorWalls& walls) const {
  const double turn2 = options_.wall_direction_sigma_rad * options_.wall_direction_sigma_rad;
  const double offset2 = options_.wall_offset_sigma_m * options_.wall_offset_sigma_m;
  walls.covariance.diagonal() += Eigen::Vector3d(turn2, offset2, offset2);
  if (walls.end) walls.end->covariance.diagonal() += Eigen::Vector2d(offset2, turn2);
}

void CorridorIns::Engine::search_missing_walls(const LaserScan& scan,
                                               const corridor::Predicted& predicted,
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
