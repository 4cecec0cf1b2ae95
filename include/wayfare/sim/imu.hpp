#pragma once

// An inertial unit on a vehicle, with configurable errors.

#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/sensors/imu.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

namespace wayfare::sim {

/// Defaults: 100 Hz, aligned with the body, errors of an automotive MEMS unit.
struct ImuParams {
  ImuNoise noise;
  Duration period{10'000'000};
  SO3d q_body_imu;  ///< mounting: rotates the unit's axes to the body's
  /// Each sample is the mean since the previous one, as of an integrating unit; else the instant's
  /// value.
  bool mean_of_period = false;
};

/// Errors of a unit at one instant, in its own axes, besides white noise.
struct ImuErrors {
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d gyro_scale = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_scale = Eigen::Vector3d::Zero();
};

struct SimulatedImu {
  std::vector<ImuSample> samples;
  std::vector<ImuErrors> errors;  ///< one per sample
};

/// Errors over time: four Gauss-Markov processes per unit, started in their stationary distribution
/// and discretised exactly, n ← e^(−T/τ) n + σ√(1 − e^(−2T/τ)) w.
class ImuErrorProcess {
 public:
  ImuErrorProcess(const ImuNoise& noise, Rng& rng);
  void step(double seconds, Rng& rng);
  [[nodiscard]] const ImuErrors& errors() const { return errors_; }

 private:
  ImuNoise noise_;
  ImuErrors errors_;
};

/// A unit on the vehicle, sample by sample: (1 + scale) ∘ true + bias + white noise whose standard
/// deviation is its density over √period. The trajectory must outlive it.
class SimulatedUnit {
 public:
  /// The first sample is at trajectory.begin().
  SimulatedUnit(const VehicleTrajectory& trajectory, const ImuParams& params, const Rng& rng);
  /// False at the end of the trajectory.
  [[nodiscard]] bool read(ImuSample& sample);
  /// Of the last sample.
  [[nodiscard]] const ImuErrors& errors() const { return process_.errors(); }

 private:
  const VehicleTrajectory& trajectory_;
  ImuParams params_;
  Rng rng_;
  ImuErrorProcess process_;
  LogTime next_;
};

/// All samples of a trajectory.
[[nodiscard]] SimulatedImu simulate_imu(const VehicleTrajectory& trajectory,
                                        const ImuParams& params, const Rng& rng);

/// No error of any kind.
[[nodiscard]] ImuNoise perfect_imu();

}  // namespace wayfare::sim
