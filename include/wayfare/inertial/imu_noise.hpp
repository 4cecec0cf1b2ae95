#pragma once

// Error models of an inertial unit and a receiver clock. Defaults are those of an automotive MEMS
// unit such as the MPU-9250.
//
// Allan and Hadamard deviation of a sensor at rest: IEEE Std 952-1997, annex C; Riley and Howe 2008
// (NIST SP 1065).
//
// Identification of a first-order Gauss-Markov process from its autocorrelation (Gelb 1974, section
// 2.5).

#include <array>
#include <cstddef>
#include <numbers>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/detail/eigen_alignment.hpp>

namespace wayfare {

/// A first-order Gauss-Markov process per axis, ṅ = −n/τ + √(2σ²/τ) w: stationary standard
/// deviation σ, correlation time τ.
struct GaussMarkov3 {
  Eigen::Vector3d sigma;  ///< stationary standard deviation, per axis
  Eigen::Vector3d tau_s;  ///< correlation time, per axis
};

/// Errors of one inertial unit: measured = (1 + scale) ∘ true + bias + white noise, per axis.
struct ImuNoise {
  /// White noise (angle and velocity random walk): rad/√s and m/s/√s.
  Eigen::Vector3d gyro_white_rad_per_sqrt_s =
      Eigen::Vector3d::Constant(0.01 * std::numbers::pi / 180.0);
  /// Velocity random walk.
  Eigen::Vector3d accel_white_mps_per_sqrt_s = Eigen::Vector3d::Constant(300e-6 * 9.80665);
  /// Slow error of the rate.
  GaussMarkov3 gyro_bias_radps = {Eigen::Vector3d::Constant(0.05 * std::numbers::pi / 180.0),
                                  Eigen::Vector3d::Constant(3000.0)};
  /// Slow error of the force.
  GaussMarkov3 accel_bias_mps2 = {Eigen::Vector3d::Constant(0.03),
                                  Eigen::Vector3d::Constant(3000.0)};
  /// Relative error of the rate.
  GaussMarkov3 gyro_scale = {Eigen::Vector3d::Constant(0.003), Eigen::Vector3d::Constant(20000.0)};
  /// Relative error of the force.
  GaussMarkov3 accel_scale = {Eigen::Vector3d::Constant(0.003), Eigen::Vector3d::Constant(20000.0)};
};

/// Receiver clock: random walks of bias and drift, in metres (times the speed of light).
struct ReceiverClockNoise {
  double bias_walk_m_per_sqrt_s = 0.3;     ///< of the bias, after one second
  double drift_walk_mps_per_sqrt_s = 0.1;  ///< of the drift, after one second
};

/// Deviation at one averaging time, in the unit of the readings.
struct AllanPoint {
  double tau_s = 0.0;      ///< averaging time
  double deviation = 0.0;  ///< in the unit of the readings
  /// Relative standard deviation of `deviation`: 1/√(2(n − 1)) for n averaging times in the record
  /// (IEEE 952, (C.20)), conservative for overlapping averages.
  double relative_sigma = 0.0;
};
using AllanCurve = std::vector<AllanPoint>;  ///< in order of averaging time

/// Processes readings one by one; stores a few kilobytes per doubling of the record length.
/// Averages of up to 64 readings overlap fully; longer ones advance by at most 1/32 of the
/// averaging time, which loses at most a few per cent of the information.
class AllanRecorder {
 public:
  /// `period_s` between readings, which are evenly spaced.
  explicit AllanRecorder(double period_s);

  /// Non-finite values, and those above 1e100, are ignored.
  void add(double value);
  /// Number of readings.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Of the readings.
  [[nodiscard]] double mean() const;

  /// Allan deviation: of first differences of means.
  [[nodiscard]] AllanCurve allan() const { return curve(false); }
  /// Hadamard deviation: of second differences, insensitive to a constant drift. Equals the Allan
  /// deviation for white noise.
  [[nodiscard]] AllanCurve hadamard() const { return curve(true); }

 private:
  /// Squared differences of the running sum at one number of steps.
  struct Sums {
    int steps = 0;
    double allan = 0.0, hadamard = 0.0;
    std::size_t allan_count = 0, hadamard_count = 0;
  };
  static constexpr std::size_t kRing = 256;
  /// The running sum after every 2^level readings.
  struct Level {
    std::array<double, kRing> sum{};
    std::size_t count = 0;
    std::vector<Sums> sums;
  };
  void add_sum(std::size_t level, double sum);
  [[nodiscard]] AllanCurve curve(bool hadamard) const;

  double period_s_;
  std::size_t count_ = 0;
  double first_ = 0.0;
  double sum_ = 0.0, compensation_ = 0.0;  ///< of readings less the first; Kahan
  std::vector<Level> levels_;
};

/// A coefficient and its standard deviation; zero if the curve does not contain it.
struct AllanCoefficient {
  double value = 0.0;  ///< in its own unit, see AllanFit
  double sigma = 0.0;  ///< standard deviation
  /// Averaging times at which this error contributes at least a third of the variance; zero: none.
  double from_s = 0.0,  ///< shortest
      to_s = 0.0;       ///< longest
};

/// Coefficients of the Allan variance 3Q²/τ² + N²/τ + (2 ln 2/π)B² + K²τ/3. For a gyro in rad/s
/// their units are rad, rad/√s, rad/s and rad/s/√s.
struct AllanFit {
  AllanCoefficient quantisation;      ///< Q
  AllanCoefficient random_walk;       ///< N: angle or velocity random walk (white noise)
  AllanCoefficient bias_instability;  ///< B: flicker noise
  AllanCoefficient rate_random_walk;  ///< K
  double floor = 0.0,                 ///< lowest point over √(2 ln 2/π)
      floor_tau_s = 0;                ///< its averaging time
};

/// Non-negative least squares on the relative variance, each point weighted by its own uncertainty
/// and a model error of 3 %. Averaging times that fit into the record fewer than `least_averages`
/// times are left out, and points that are not finite and positive. Of more than 500 points, every
/// n-th is used. All zero for fewer than three.
[[nodiscard]] AllanFit fit_allan(std::span<const AllanPoint> curve, double least_averages = 9.0);

/// R(t) = σ² e^(−t/τ) of the slow part of a record; `found` is false if its autocorrelation does
/// not decay within the record.
struct GaussMarkovFit {
  bool found = false;  ///< the autocorrelation decays within the record
  double sigma = 0.0,  ///< of the process, in the unit of the readings
      tau_s = 0.0;     ///< its correlation time
  /// Standard deviations, from the covariance of the lags of such a process (Bartlett 1946).
  double sigma_sigma = 0.0,  ///< of `sigma`
      tau_sigma_s = 0.0;     ///< of `tau_s`
};

/// Processes readings one by one; stores means of blocks that double in length as the record grows.
class AutocorrelationRecorder {
 public:
  /// `period_s` between evenly spaced readings; at most `blocks` means are stored.
  explicit AutocorrelationRecorder(double period_s, std::size_t blocks = 32768);

  /// Non-finite values, and those above 1e100, are ignored.
  void add(double value);

  /// Autocorrelation of the block means about their mean, at multiples of block_s().
  [[nodiscard]] std::vector<double> autocorrelation(std::size_t lags) const;
  /// Duration of a block.
  [[nodiscard]] double block_s() const { return period_s_ * static_cast<double>(length_); }

  /// Generalised least squares on the lags from one (white noise affects lag zero only) until the
  /// correlation has fallen to a quarter. The model includes the bias from subtracting the record's
  /// mean.
  [[nodiscard]] GaussMarkovFit fit() const;

 private:
  void close_block();

  double period_s_;
  std::size_t max_blocks_;
  std::size_t length_ = 1;  ///< readings per block
  std::size_t in_block_ = 0;
  double first_ = 0.0, block_sum_ = 0.0;
  bool started_ = false;
  std::vector<double> means_;
};

}  // namespace wayfare
