#include <cmath>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/geodesy.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

namespace wayfare::sim {
namespace {

/// Of the axle along the body's forward axis.
double forward_mps(const VehicleMotion& motion, const Eigen::Vector3d& lever_arm_m) {
  const Eigen::Matrix3d ecef_body =
      rotation_ecef_ned(motion.nav.position) * motion.nav.q_nb.matrix();
  return ecef_body.col(0).dot(ecef_motion(motion, lever_arm_m).velocity_mps);
}

/// When wheels slip, and by which fraction of the speed.
class Slips {
 public:
  Slips(const WheelSpeedParams& params, const Rng& rng) : params_(params), rng_(rng) {}

  /// The fraction over the next `seconds`; zero: none.
  double step(double seconds) {
    left_s_ -= seconds;
    const double begin = rng_.uniform(), length = rng_.uniform(), size = rng_.uniform(),
                 side = rng_.uniform();
    if (left_s_ > 0.0) return fraction_;
    fraction_ = 0.0;
    if (begin < -std::expm1(-params_.slips_per_hour * seconds / 3600.0)) {
      left_s_ = -params_.mean_slip_s * std::log1p(-length);
      fraction_ = -params_.mean_slip_fraction * std::log1p(-size) * (side < 0.5 ? -1.0 : 1.0);
    }
    return fraction_;
  }

 private:
  WheelSpeedParams params_;
  Rng rng_;
  double left_s_ = 0.0, fraction_ = 0.0;
};

}  // namespace

SimulatedWheelSpeeds simulate_wheel_speeds(const VehicleTrajectory& trajectory,
                                           const WheelSpeedParams& params, const Rng& rng) {
  WAYFARE_EXPECTS(params.period > Duration::zero(), "wheels need a positive period");
  Rng white = rng.stream(0);
  Slips slips(params, rng.stream(1));
  SimulatedWheelSpeeds result;
  for (LogTime t = trajectory.begin(); t <= trajectory.end(); t += params.period) {
    const double slip = slips.step(to_seconds(params.period));
    double speed = (1.0 + params.scale) * (1.0 + slip) *
                       forward_mps(trajectory.motion(t), params.lever_arm_m) +
                   white.normal(0.0, params.sigma_mps);
    if (params.resolution_mps > 0.0)
      speed = params.resolution_mps * std::round(speed / params.resolution_mps);
    result.readings.push_back({t, speed});
    result.slips.push_back(slip != 0.0);
  }
  return result;
}

}  // namespace wayfare::sim
