#pragma once

// Blocks of a state that move by themselves: x⁺ = Φ x + w with w ~ N(0, Q), exact for any step.
// Derive a block from one and name its errors:
//
//   struct GyroBias : GaussMarkov<3> {
//     static constexpr BlockNames<3> kNames{"gyro bias x", "gyro bias y", "gyro bias z"};
//   };
//   GyroBias bias{{0.01, 100.0}};        // standard deviation, correlation time in seconds

#include <Eigen/Core>

#include <wayfare/filter/gauss_markov.hpp>
#include <wayfare/filter/state.hpp>

namespace wayfare {

/// Φ of a block that noise alone changes.
struct Unchanged {};
/// Q of a block without noise.
struct NoNoise {};

/// Φ and Q of a block over a step. `phi`: Unchanged, a vector (the diagonal), a matrix, or a
/// callable from errors to errors. `noise`: NoNoise, a vector (the variances) or a matrix.
template <class Phi, class Noise>
struct BlockStep {
  Phi phi;      ///< transition of the errors
  Noise noise;  ///< covariance added
};

/// Constant but unknown, as a scale or a lever arm.
template <int N, class T = double>
struct RandomConstant {
  using Value = Eigen::Matrix<T, N, 1>;  ///< in any unit
  /// Φ = I, Q = 0.
  [[nodiscard]] BlockStep<Unchanged, NoNoise> discretise(double) const { return {}; }
};

/// The integral of white noise of `density`, unit/√s.
template <int N, class T = double>
struct RandomWalk {
  using Value = Eigen::Matrix<T, N, 1>;   ///< in any unit
  Value density = Value::Constant(T(0));  ///< standard deviation after one second

  RandomWalk() = default;
  /// The same density for every component.
  RandomWalk(const T& of_all) : density(Value::Constant(of_all)) {}
  /// A density for each component.
  RandomWalk(const Value& of_each) requires(N > 1) : density(of_each) {}

  /// Φ = I, Q = density² dt.
  [[nodiscard]] BlockStep<Unchanged, Value> discretise(double dt_s) const {
    return {{}, T(dt_s) * density.cwiseAbs2()};
  }
};

/// Exponentially correlated, ẋ = −x/τ + √(2σ²/τ) w, of the first order (see gauss_markov.hpp).
template <int N, class T = double>
struct GaussMarkov {
  using Value = Eigen::Matrix<T, N, 1>;  ///< in any unit
  Value sigma = Value::Constant(T(0)),   ///< stationary standard deviation
      tau_s = Value::Constant(T(1));     ///< correlation time

  GaussMarkov() = default;
  /// The same parameters for every component.
  GaussMarkov(const T& sigma_of_all, const T& tau_of_all_s)
      : sigma(Value::Constant(sigma_of_all)), tau_s(Value::Constant(tau_of_all_s)) {}
  /// Parameters for each component.
  GaussMarkov(const Value& sigma_of_each, const Value& tau_of_each_s) requires(N > 1)
      : sigma(sigma_of_each), tau_s(tau_of_each_s) {}

  /// φ = e^(−dt/τ), q = σ²(1 − e^(−2dt/τ)) for each component.
  [[nodiscard]] BlockStep<Value, Value> discretise(double dt_s) const {
    BlockStep<Value, Value> step;
    for (int i = 0; i < N; ++i) {
      const ProcessStep1<T> one = discretise_gauss_markov(sigma[i], tau_s[i], T(dt_s));
      step.phi[i] = one.phi;
      step.noise[i] = one.q;
    }
    return step;
  }
};

/// A receiver's clock: bias (m) and drift (m/s), both random walks, the drift integrated into the
/// bias; then `Offsets` offsets between systems (m), random walks. See discretise_clock.
template <int Offsets = 0, class T = double>
struct ReceiverClockBlock {
  static constexpr int kDof = 2 + Offsets;  ///< bias, drift and offsets
  using Value = Eigen::Matrix<T, kDof, 1>;  ///< m, m/s, then m
  T bias_walk = T(0),                       ///< standard deviation after one second, m/√s
      drift_walk = T(0),                    ///< m/s/√s
      offset_walk = T(0);                   ///< m/√s

  /// The drift integrated into the bias.
  struct Phi {
    T dt_s;  ///< the step
    /// Φ d of the errors d.
    [[nodiscard]] Value operator()(Value d) const {
      d[0] += dt_s * d[1];
      return d;
    }
  };
  using Noise = Eigen::Matrix<T, kDof, kDof>;  ///< bias and drift are correlated
  /// Φ and Q over `dt_s`.
  [[nodiscard]] BlockStep<Phi, Noise> discretise(double dt_s) const {
    const ClockStep<T> clock = discretise_clock(bias_walk, drift_walk, T(dt_s));
    Noise noise = Noise::Constant(T(0));
    noise.diagonal().setConstant(offset_walk * offset_walk * T(dt_s));
    noise.template topLeftCorner<2, 2>() << clock.bias_variance, clock.covariance, clock.covariance,
        clock.drift_variance;
    return {{T(dt_s)}, noise};
  }
};

}  // namespace wayfare
