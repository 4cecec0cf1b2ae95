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
struct NoNoise {};

/// Φ and Q of a block over a step. `phi`: Unchanged, a vector (the diagonal), a matrix, or a
/// callable from errors to errors. `noise`: NoNoise, a vector (the variances) or a matrix.
template <class Phi, class Noise>
struct BlockStep {
  Phi phi;
  Noise noise;
};

/// Constant but unknown, as a scale or a lever arm.
template <int N, class T = double>
struct RandomConstant {
  using Value = Eigen::Matrix<T, N, 1>;
  [[nodiscard]] BlockStep<Unchanged, NoNoise> discretise(double) const { return {}; }
};

/// The integral of white noise of `density`, unit/√s.
template <int N, class T = double>
struct RandomWalk {
  using Value = Eigen::Matrix<T, N, 1>;
  Value density = Value::Constant(T(0));

  RandomWalk() = default;
  RandomWalk(const T& of_all) : density(Value::Constant(of_all)) {}
  RandomWalk(const Value& of_each) requires(N > 1) : density(of_each) {}

  [[nodiscard]] BlockStep<Unchanged, Value> discretise(double dt_s) const {
    return {{}, T(dt_s) * density.cwiseAbs2()};
  }
};

/// Exponentially correlated, ẋ = −x/τ + √(2σ²/τ) w, of the first order (see gauss_markov.hpp).
template <int N, class T = double>
struct GaussMarkov {
  using Value = Eigen::Matrix<T, N, 1>;
  Value sigma = Value::Constant(T(0)), tau_s = Value::Constant(T(1));

  GaussMarkov() = default;
  GaussMarkov(const T& sigma_of_all, const T& tau_of_all_s)
      : sigma(Value::Constant(sigma_of_all)), tau_s(Value::Constant(tau_of_all_s)) {}
  GaussMarkov(const Value& sigma_of_each, const Value& tau_of_each_s) requires(N > 1)
      : sigma(sigma_of_each), tau_s(tau_of_each_s) {}

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
  static constexpr int kDof = 2 + Offsets;
  using Value = Eigen::Matrix<T, kDof, 1>;
  T bias_walk = T(0), drift_walk = T(0), offset_walk = T(0);  ///< m/√s, m/s/√s, m/√s

  struct Phi {
    T dt_s;
    [[nodiscard]] Value operator()(Value d) const {
      d[0] += dt_s * d[1];
      return d;
    }
  };
  using Noise = Eigen::Matrix<T, kDof, kDof>;
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
