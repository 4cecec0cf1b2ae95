#pragma once

// The navigation filter beside Hector SLAM (Kohlbrecher et al. 2011, section IV): six degrees of
// freedom from an inertial unit on a head, in a hand or on a rig, aided by planar scan matches.
// Over a flat, non-rotating floor, for rooms and minutes. (Over the Earth: ins_model.hpp.)

#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/filter/state.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/rest_detector.hpp>
#include <wayfare/inertial/detail/sample_clock.hpp>
#include <wayfare/inertial/ins_state.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// The blocks of CarrierState beside the biases. Map axes have z up; the body's x points forward, z
/// up.
namespace carrier {

/// Position of the body in the map.
struct Position {
  using Value = Eigen::Vector3d;  ///< m
  /// Member of states.
  struct Storage {
    Value position_m = Value::Zero();  ///< m
  };
  static constexpr auto kMember = &Storage::position_m;  ///< where states keep it
  /// Of its errors.
  static constexpr BlockNames<3> kNames{"position x", "position y", "position z"};
};

/// Velocity of the body in the map.
struct Velocity {
  using Value = Eigen::Vector3d;  ///< m/s
  /// Member of states.
  struct Storage {
    Value velocity_mps = Value::Zero();  ///< m/s
  };
  static constexpr auto kMember = &Storage::velocity_mps;  ///< where states keep it
  /// Of its errors.
  static constexpr BlockNames<3> kNames{"velocity x", "velocity y", "velocity z"};
};

/// Attitude of the body; its error in the body's axes, rad.
struct Attitude {
  using Value = SO3d;  ///< body to map
  /// Member of states.
  struct Storage {
    Value q_map_body;  ///< body to map
  };
  static constexpr auto kMember = &Storage::q_map_body;  ///< where states keep it
  /// Of its errors.
  static constexpr BlockNames<3> kNames{"attitude x", "attitude y", "attitude z"};
};

using GyroBias = ins::GyroBias<double>;                                   ///< rad/s
using AccelBias = ins::AccelBias<double>;                                 ///< m/s²
using Blocks = State<Position, Velocity, Attitude, GyroBias, AccelBias>;  ///< in this order

}  // namespace carrier

/// Fifteen errors.
struct CarrierState : carrier::Blocks {
  static constexpr int kPosition = index<carrier::Position>(),  ///< place of the errors
      kVelocity = index<carrier::Velocity>(),                   ///< place of the errors
      kAttitude = index<carrier::Attitude>(),                   ///< place of the errors
      kGyroBias = index<carrier::GyroBias>(),                   ///< place of the errors
      kAccelBias = index<carrier::AccelBias>();                 ///< place of the errors

  /// x ⊞ τ.
  [[nodiscard]] CarrierState plus(const Tangent& tau) const { return {carrier::Blocks::plus(tau)}; }

  /// Seen from above: x, y and the heading of the body's x axis.
  [[nodiscard]] SE2d planar() const;
  /// ∂(x, y, heading)/∂τ, x and y along the map's axes.
  [[nodiscard]] Eigen::Matrix<double, 3, kDof> planar_jacobian() const;
};

/// White noise of the samples, rad/√s and m/s/√s, and biases as Gauss-Markov processes. The noise
/// also covers scale and alignment errors and shocks.
struct CarrierNoise {
  double gyro_white = 0.001;       ///< rad/√s
  double accel_white = 0.03;       ///< m/s/√s
  double gyro_bias_radps = 0.01,   ///< rad/s, stationary σ
      gyro_bias_time_s = 1000.0;   ///< its correlation time
  double accel_bias_mps2 = 0.05,   ///< m/s², stationary σ
      accel_bias_time_s = 1000.0;  ///< its correlation time
};

/// The process model (see ProcessModel): q⁺ = q exp(Δθ), v⁺ = v + q Δv − g Δt, p⁺ = p + Δt (v +
/// v⁺)/2 with Δθ, Δv of the samples less the biases.
class CarrierModel {
 public:
  static constexpr double kGravity_mps2 = 9.80665;  ///< of the map's level
  using Square = Eigen::Matrix<double, CarrierState::kDof, CarrierState::kDof>;  ///< covariances

  /// A state, its transition and noise.
  struct Step {
    CarrierState state;  ///< after the step
    Square phi,          ///< Φ
        q;               ///< Q
  };

  /// With the noise of the samples.
  explicit CarrierModel(const CarrierNoise& noise = {}) : noise_(noise) {}

  /// Samples in the body's axes.
  [[nodiscard]] Step operator()(const CarrierState& x, const ImuInterval& u) const;

 private:
  CarrierNoise noise_;
};

/// Noise, floor, rest and gaps of a CarrierFilter.
struct CarrierFilterParameters {
  CarrierNoise noise{};  ///< of the samples
  /// The floor is level: height and vertical velocity are zero-mean processes of these standard
  /// deviations, m and m/s, and this correlation time, s. They model a head's bob.
  double height_sigma_m = 0.05,  ///< σ of the height
      climb_sigma_mps = 0.3,     ///< σ of the vertical velocity
      height_time_s = 0.5;       ///< their correlation time
  /// Upper limit of the standard deviation of horizontal velocity about zero, m/s: walking speed.
  /// Keeps the vertical observable without matches.
  double speed_sigma_mps = 1.5;
  /// At rest: rate (rad/s) and specific force (m/s²) stay this close to their averages for this
  /// time, s, and the average rate could be a bias. Velocity is then zero to `rest_sigma_mps`.
  double rest_rate = 0.035,        ///< rad/s
      rest_force = 0.5,            ///< m/s²
      rest_time_s = 1.5,           ///< s
      rest_bias_limit = 0.05;      ///< largest mean rate that is taken for a bias, rad/s
  double rest_sigma_mps = 0.02,    ///< σ of the velocity at rest
      rest_rate_density = 0.0005;  ///< noise of the rate at rest, rad/s/√Hz
  /// A longer gap, s, initialises level and velocity again. The filter has no estimate for times
  /// more than `silence_s` from the last sample.
  double restart_gap_s = 0.5,  ///< s
      silence_s = 0.3;         ///< s
  /// Whether match errors are taken as independent of the state's. They are not: the map was built
  /// from the estimated poses, and each match starts from the estimate.
  bool independent_matches = false;
  /// Mean horizontal acceleration, m/s², that nobody sustains for a second: the level is lost.
  double lost_level_mps2 = 4.0;
};

/// Takes samples in the body's axes (x forward, z up) and matches, in order of time. Error state as
/// in CarrierState.
class CarrierFilter {
 public:
  using Square = CarrierModel::Square;  ///< covariances

  /// Without samples.
  explicit CarrierFilter(const CarrierFilterParameters& parameters = {});

  /// `late` and `missing` samples change nothing; `waiting`: no attitude can be derived from it
  /// yet.
  UpdateStatus add(const ImuSample& sample);

  /// Whether there is an attitude, and a sample near `time`.
  [[nodiscard]] bool covers(LogTime time) const;
  /// Extrapolates to `time` with the last sample; nothing if `time` is not later than the state.
  void advance(LogTime time);
  /// Whether planar position and heading have been set since the last initialisation.
  [[nodiscard]] bool placed() const { return placed_; }
  /// Sets the planar pose with these standard deviations. Level, biases and speed are kept.
  void place(const SE2d& T_map_base, double sigma_m, Angle sigma);
  /// Fuses a match by covariance intersection, its covariance in the matched pose's own axes.
  /// Returns the match's weight ω; nothing if it could not be used.
  std::optional<double> fuse(const SE2d& T_map_base, const Eigen::Matrix3d& covariance);

  /// At the time of the last sample or match.
  [[nodiscard]] const CarrierState& state() const { return ekf_.state(); }
  /// Of the errors of state().
  [[nodiscard]] const Square& covariance() const { return ekf_.covariance(); }
  /// Seen from above: x, y and the heading.
  [[nodiscard]] SE2d planar() const { return state().planar(); }
  /// Of `planar()`, in its own axes.
  [[nodiscard]] Eigen::Matrix3d planar_covariance() const;
  /// Rotates the body's axes to level ones whose x is the heading.
  [[nodiscard]] SO3d q_level_body() const;
  /// By the rest detector.
  [[nodiscard]] bool at_rest() const;
  /// Standard deviation of the vertical about its worse axis.
  [[nodiscard]] Angle level_sigma() const;
  /// Number of initialisations.
  [[nodiscard]] std::size_t starts() const { return starts_; }

 private:
  void start(const ImuSample& sample);
  void step(const ImuSample& from, const ImuSample& to);
  void apply_floor_constraints(double elapsed_s);
  void apply_zero_velocity(double elapsed_s);
  bool level_lost(const ImuSample& sample, double dt_s);

  CarrierFilterParameters p_;
  CarrierModel model_;
  Ekf<CarrierState> ekf_;
  RestDetector<double> rest_;
  SampleClock clock_{1.0};
  std::optional<ImuSample> last_;
  LogTime time_;  // of the state
  bool placed_ = false;
  double since_constraint_s_ = 0.0, lost_s_ = 0.0;
  Eigen::Vector3d mean_force_ = Eigen::Vector3d::Zero();  // map axes, over a second
  std::size_t starts_ = 0;
};

}  // namespace wayfare
