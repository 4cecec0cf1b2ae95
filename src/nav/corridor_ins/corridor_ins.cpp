#include <wayfare/nav/corridor_ins.hpp>

#include <array>
#include <cmath>

#include "nav/corridor_ins/engine.hpp"

namespace wayfare {

using namespace corridor_state;

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
