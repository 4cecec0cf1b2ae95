#include <wayfare/sim/vehicle_trajectory.hpp>

#include <cmath>

namespace wayfare::sim {
namespace {

Eigen::Vector3d white(Rng& rng) {
  Eigen::Vector3d w;
  for (double& x : w) x = rng.normal();
  return w;
}

void step_process(Eigen::Vector3d& n, const GaussMarkov3& process, double seconds, Rng& rng) {
  for (int i = 0; i < 3; ++i) {
    const double phi = std::exp(-seconds / process.tau_s[i]);
    const double q = -std::expm1(-2.0 * seconds / process.tau_s[i]);
    n[i] = phi * n[i] + process.sigma[i] * std::sqrt(q) * rng.normal();
  }
}

struct Reading {
  Eigen::Vector3d rate, force;
};

Reading reading_at(const VehicleTrajectory& trajectory, LogTime time) {
  const VehicleMotion m = trajectory.motion(time);
  return {m.angular_rate_radps, m.specific_force_mps2};
}

// Two-point Gauss-Legendre: exact to the third order within a spline's segment.
Reading mean_reading(const VehicleTrajectory& trajectory, LogTime from, Duration period) {
  const double half = 0.5 * to_seconds(period), offset = half / std::sqrt(3.0);
  const Reading a = reading_at(trajectory, from + from_seconds(half - offset));
  const Reading b = reading_at(trajectory, from + from_seconds(half + offset));
  return {0.5 * (a.rate + b.rate), 0.5 * (a.force + b.force)};
}

}  // namespace

ImuErrorProcess::ImuErrorProcess(const ImuNoise& noise, Rng& rng) : noise_(noise) {
  errors_.gyro_bias_radps = noise.gyro_bias_radps.sigma.cwiseProduct(white(rng));
  errors_.accel_bias_mps2 = noise.accel_bias_mps2.sigma.cwiseProduct(white(rng));
  errors_.gyro_scale = noise.gyro_scale.sigma.cwiseProduct(white(rng));
  errors_.accel_scale = noise.accel_scale.sigma.cwiseProduct(white(rng));
}

void ImuErrorProcess::step(double seconds, Rng& rng) {
  step_process(errors_.gyro_bias_radps, noise_.gyro_bias_radps, seconds, rng);
  step_process(errors_.accel_bias_mps2, noise_.accel_bias_mps2, seconds, rng);
  step_process(errors_.gyro_scale, noise_.gyro_scale, seconds, rng);
  step_process(errors_.accel_scale, noise_.accel_scale, seconds, rng);
}

SimulatedUnit::SimulatedUnit(const VehicleTrajectory& trajectory, const ImuParams& params,
                             const Rng& rng)
    : trajectory_(trajectory),
      params_(params),
      rng_(rng),
      process_(params.noise, rng_),
      next_(trajectory.begin()) {
  WAYFARE_EXPECTS(params.period > Duration::zero(), "a sensor needs a positive period");
}

bool SimulatedUnit::read(ImuSample& sample) {
  if (next_ > trajectory_.end()) return false;
  const double dt = to_seconds(params_.period);
  const Reading truth = params_.mean_of_period
                            ? mean_reading(trajectory_, next_ - params_.period, params_.period)
                            : reading_at(trajectory_, next_);
  if (next_ > trajectory_.begin()) process_.step(dt, rng_);
  const SO3d q_imu_body = params_.q_body_imu.inverse();
  const auto err = [&](const Eigen::Vector3d& body, const Eigen::Vector3d& scale,
                       const Eigen::Vector3d& bias, const Eigen::Vector3d& density) {
    const Eigen::Vector3d own = q_imu_body * body;
    return Eigen::Vector3d(own + own.cwiseProduct(scale) + bias +
                           density.cwiseProduct(white(rng_)) / std::sqrt(dt));
  };
  const ImuErrors& e = errors();
  sample.time = next_;
  sample.angular_rate_radps =
      err(truth.rate, e.gyro_scale, e.gyro_bias_radps, params_.noise.gyro_white_rad_per_sqrt_s);
  sample.specific_force_mps2 =
      err(truth.force, e.accel_scale, e.accel_bias_mps2, params_.noise.accel_white_mps_per_sqrt_s);
  next_ += params_.period;
  return true;
}

SimulatedImu simulate_imu(const VehicleTrajectory& trajectory, const ImuParams& params,
                          const Rng& rng) {
  SimulatedUnit unit(trajectory, params, rng);
  SimulatedImu imu;
  for (ImuSample sample; unit.read(sample);) {
    imu.samples.push_back(sample);
    imu.errors.push_back(unit.errors());
  }
  return imu;
}

ImuNoise perfect_imu() {
  const GaussMarkov3 none{Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones()};
  return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), none, none, none, none};
}

}  // namespace wayfare::sim
