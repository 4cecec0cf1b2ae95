#pragma once

// Many inertial readings as one step of the covariance: the state moves by each reading, and
// P ← Φ P Φᵀ + Q is computed once for all, with Φ and Q from sums over the readings.
//
// About the axes of local level the attitude error of Strapdown does not change, so that Φ is made
// of integrals: of the unit's axes, of the velocity gained, and of their products. What the noise
// of one reading has become at the end is a difference of such integrals; Q, the sum over all
// noises, is interpolated by parabolas between few nodes, as in Simpson's rule. The Earth, and the
// turn of velocity errors by its rotation, less than 2e-4 rad a second, change at the nodes only.

#include <algorithm>
#include <array>
#include <cstddef>
#include <tuple>

#include <Eigen/Core>

#include <wayfare/filter/gauss_markov.hpp>
#include <wayfare/inertial/ins_model.hpp>

#include "tune/kernels/interval_jacobian.hpp"
#include "tune/kernels/interval_sums.hpp"
#include "tune/kernels/kernels.hpp"

namespace wayfare::fitness_kernels {

/// Moves a state by readings, and the covariance by all of them since the beginning of an interval.
template <class T>
class ComposedSteps {
 public:
  using State = InsState<T, 0>;
  using Square = SquareOf<State>;
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  using Matrix3 = Eigen::Matrix<T, 3, 3>;

  ComposedSteps(const LocalTangentPlane& plane, const InsNoise<T>& noise, double nominal_dt_s)
      : plane_(plane),
        noise_(noise),
        gyro_variance_(noise.gyro_white.cwiseAbs2()),
        accel_variance_(noise.accel_white.cwiseAbs2()),
        nominal_dt_s_(nominal_dt_s),
        kept_(kept(nominal_dt_s)) {
    for (int i = 0; i < kSensors; ++i)
      noise_rate_[i] = sensor_error(i, nominal_dt_s).q / T(nominal_dt_s);
  }

  /// An interval begins at `x`.
  void begin(const State& x) {
    x_ = x;
    now_.begin(x.q_nu.matrix());
    turned_ = Matrix3::Identity();
    turned_s_ = Matrix3::Constant(T(0));
    nodes_ = 0;
    for (Node& n : node_) n.noise_s = n.longer_s2 = 0.0, n.gyro_noise = Vector3::Constant(T(0));
    mark();
  }

  /// After the latest reading.
  [[nodiscard]] const State& state() const { return x_; }

  /// Moves the state by a step's reading. `vibration`: the variance it adds to the attitude about
  /// the unit's axes, rad².
  __attribute__((flatten)) void add(const Step& step, const Vector3& vibration) {
    const ImuInterval& u = step.imu;
    const T dt = T(u.dt_s);
    const CorrectedImu<T> imu(x_.gyro_bias_radps, x_.accel_bias_mps2, x_.gyro_scale, x_.accel_scale,
                              u);
    const InertialIncrement<T> measured =
        integrate(imu.begin_rate, imu.end_rate, imu.begin_force, imu.end_force, dt);
    const LevelRates<T> rates = level_rates(earth_, x_.velocity_mps);
    now_.turn -= dt * (T(2) * rates.earth + rates.transport);
    const Navigation<T> next =
        strapdown_step({x_.position_m, x_.velocity_mps, x_.q_nu}, earth_, measured, dt);
    x_.position_m = next.position_m;
    x_.velocity_mps = next.velocity_mps;
    x_.q_nu = next.q_nu;

    const auto left = [this](int block) { return now_.left.template segment<3>(3 * block); };
    const Vector3 by_gyro = -dt * imu.inverse_gyro_scale, by_accel = -dt * imu.inverse_accel_scale;
    const Vector3 rate = Strapdown<T>::beyond_noise(measured.mean_rate_radps, noise_.gyro_white,
                                                    noise_.sigma.template segment<3>(0), dt);
    const Vector3 force = Strapdown<T>::beyond_noise(measured.mean_force_mps2, noise_.accel_white,
                                                     noise_.sigma.template segment<3>(3), dt);
    now_.add(x_.q_nu.matrix(), measured.velocity_mps,
             {by_gyro.cwiseProduct(left(0)), by_accel.cwiseProduct(left(1)),
              by_gyro.cwiseProduct(rate).cwiseProduct(left(2)),
              by_accel.cwiseProduct(force).cwiseProduct(left(3))},
             u.dt_s);

    const Vector12 kept = u.dt_s == nominal_dt_s_ ? kept_ : this->kept(u.dt_s);
    x_.gyro_bias_radps.array() *= kept.template segment<3>(0).array();
    x_.accel_bias_mps2.array() *= kept.template segment<3>(3).array();
    x_.gyro_scale.array() *= kept.template segment<3>(6).array();
    x_.accel_scale.array() *= kept.template segment<3>(9).array();
    now_.left.array() *= kept.array();
    x_.clock[0] += dt * x_.clock[1];

    for (std::size_t k = 0; k < step.shares.size(); ++k) {
      Node& n = node_[step.first_node + k];
      n.noise_s += step.shares[k] * u.dt_s;
      n.longer_s2 += step.shares[k] * u.dt_s * (u.dt_s - nominal_dt_s_);
      n.gyro_noise += T(step.shares[k]) * (dt * gyro_variance_ + vibration);
    }
    if (step.ends_panel) mark();
  }

  /// The interval up to now from the state it began with, as a ProcessModel gives it.
  [[nodiscard]] auto step(const State& from) const {
    const auto error = [this](int first) {
      return GaussMarkov<3, T>{noise_.sigma.template segment<3>(first),
                               noise_.tau_s.template segment<3>(first)};
    };
    const Process<State, WholeInterval, ins::GyroBias<T>, ins::AccelBias<T>, ins::GyroScale<T>,
                  ins::AccelScale<T>, ins::Clock<T, 0>>
        process(WholeInterval{}, {error(0)}, {error(3)}, {error(6)}, {error(9)},
                {{noise_.clock_bias_walk, noise_.clock_drift_walk, noise_.clock_offset_walk}});
    return Composed{process(from, interval()), *this, x_};
  }

 private:
  /// Of the moved blocks, from those of the beginning.
  struct Interval {
    double dt_s;
    Navigation<T> moved;
    IntervalJacobian<T> jacobian;
  };
  /// A Coupling.
  struct WholeInterval {
    using Moves = typename Strapdown<T>::Moves;
    using By = typename Strapdown<T>::By;
    [[nodiscard]] auto step(const Vector3&, const Vector3&, const SO3<T>&, const Vector3&,
                            const Vector3&, const Vector3&, const Vector3&,
                            const Interval& u) const {
      return CoupledStep{std::tuple{u.moved.position_m, u.moved.velocity_mps, u.moved.q_nu},
                         u.jacobian, std::tuple{NoNoise{}, NoNoise{}, NoNoise{}}};
    }
  };
  template <class Linear>
  struct Composed {
    Linear linear;
    const ComposedSteps& steps;
    const State& state;
    void propagate(Square& p) const {
      linear.propagate(p);
      steps.add_noise(p);
    }
  };
  template <class Linear>
  Composed(Linear, const ComposedSteps&, const State&) -> Composed<Linear>;

  [[nodiscard]] __attribute__((flatten)) Interval interval() const {
    const Matrix3 begin = node_[0].at.axes, end = now_.axes.transpose();
    const Vector3 scale(earth_.north_scale, earth_.east_scale, T(1));
    const auto on_plane = [&](const Matrix3& m) -> Matrix3 { return scale.asDiagonal() * m; };
    Interval i{now_.time_s, {x_.position_m, x_.velocity_mps, x_.q_nu}, {}};
    IntervalJacobian<T>& f = i.jacobian;
    f.position_velocity = on_plane(turned_s_);
    f.position_attitude = on_plane(now_.position[kTilt] * begin);
    f.velocity_velocity = turned_;
    f.velocity_attitude = now_.velocity[kTilt] * begin;
    f.attitude_attitude = end * begin;
    for (std::size_t b = 0; b < 4; ++b) {
      f.position_sensor[b] = on_plane(now_.position[b]);
      f.velocity_sensor[b] = now_.velocity[b];
    }
    for (std::size_t b = 0; b < 2; ++b) f.attitude_sensor[b] = end * now_.attitude[b];
    return i;
  }

  /// Adds the noise of the interval but for that of the sensor errors among themselves.
  __attribute__((flatten)) void add_noise(Square& p) const {
    Noise q;
    for (std::size_t n = 0; n < nodes_; ++n) add_noise_of(node_[n], q);
    for (int j = 0; j < kMoved; ++j)
      for (int i = 0; i < j; ++i) q.moved(i, j) = q.moved(j, i);
    for (int side = 0; side < 2; ++side) {
      for (int j = 0; j < kMoved; ++j) to_errors(&q.moved(0, j));
      q.moved.transposeInPlace();
    }
    for (int j = 0; j < kSensors; ++j) to_errors(&q.with_sensors(0, j));
    for (int j = 0; j < kMoved; ++j)
      for (int i = 0; i < kMoved; ++i) p(i, j) += q.moved(std::max(i, j), std::min(i, j));
    for (int j = 0; j < kSensors; ++j)
      for (int i = 0; i < kMoved; ++i) p(kMoved + j, i) = p(i, kMoved + j) += q.with_sensors(i, j);
  }

  using Vector6 = Eigen::Matrix<T, 6, 1>;
  using Vector9 = Eigen::Matrix<T, 9, 1>;
  using Vector12 = Eigen::Matrix<T, 12, 1>;
  using Sums = IntervalSums<T>;
  static constexpr std::size_t kTilt = Sums::kTilt;
  static constexpr int kMoved = ins_state::kGyroBias;
  static constexpr int kSensors = ins_state::kClock - kMoved;
  static_assert(kMoved == 9 && kSensors == 12);

  struct Node {
    Sums at;
    double noise_s,      ///< time of which the noise is counted here
        longer_s2;       ///< the same times what its steps are longer than nominal
    Vector3 gyro_noise;  ///< variance about the unit's axes, rad²
  };
  /// Covariances of position, velocity and attitude, and with the sensor errors.
  struct Noise {
    Eigen::Matrix<T, kMoved, kMoved> moved = Eigen::Matrix<T, kMoved, kMoved>::Constant(T(0));
    Eigen::Matrix<T, kMoved, kSensors> with_sensors =
        Eigen::Matrix<T, kMoved, kSensors>::Constant(T(0));
  };

  [[nodiscard]] ProcessStep1<T> sensor_error(int i, double dt_s) const {
    return discretise_gauss_markov(noise_.sigma[i], noise_.tau_s[i], T(dt_s));
  }
  [[nodiscard]] Vector12 kept(double dt_s) const {
    Vector12 factors;
    for (int i = 0; i < kSensors; ++i) factors[i] = sensor_error(i, dt_s).phi;
    return factors;
  }

  void mark() {
    if (nodes_ > 0) turn(node_[nodes_ - 1].at);
    // The Earth at the middle of the next panel.
    const T half = T(nodes_ > 0 ? 0.5 * (now_.time_s - node_[nodes_ - 1].at.time_s) : 0.0);
    earth_ = plane_.earth(Vector3(x_.position_m + half * x_.velocity_mps));
    node_[nodes_++].at = now_;
    if (nodes_ % 2 == 1 && nodes_ > 1)
      smooth(node_[nodes_ - 3].at, node_[nodes_ - 2].at, node_[nodes_ - 1].at);
  }

  /// Turns velocity errors by what the Coriolis forces did since the node before.
  void turn(const Sums& before) {
    now_.turn_since(before);
    const Matrix3 change = cross<T>(now_.turn - before.turn, turned_);
    turned_s_ += T(now_.time_s - before.time_s) * (turned_ + T(0.5) * change);
    turned_ += change;
  }

  /// Adds the lower triangle of an effect, its first elements, by itself.
  template <int Rows>
  static void add_product(const Eigen::Matrix<T, Rows, 1>& effect, const T& variance, Noise& to) {
    for (int j = 0; j < Rows; ++j) {
      const T scaled = variance * effect[j];
      for (int i = j; i < Rows; ++i) to.moved(i, j) += scaled * effect[i];
    }
  }

  void add_noise_of(const Node& node, Noise& q) const {
    const Sums& at = node.at;
    const double s = now_.time_s - at.time_s;
    const Vector3 turn = now_.turn - at.turn;
    // What a unit of each error at the beginning did after the node; of the attitude, what one at
    // the node did.
    std::array<Matrix3, 5> velocity, position;
    for (std::size_t b = 0; b < velocity.size(); ++b) {
      const Matrix3 turned = cross(turn, at.velocity[b]);
      velocity[b] = now_.velocity[b] - at.velocity[b] - turned;
      position[b] = now_.position[b] - at.position[b] - T(s) * at.velocity[b] - T(0.5 * s) * turned;
    }
    for (int j = 0; j < 3; ++j) {
      const Vector3 a = at.axes.col(j), f = at.axes_before.col(j), turned = turn.cross(f);
      Vector9 gyro;
      gyro << position[kTilt] * a, velocity[kTilt] * a, a;
      add_product(gyro, node.gyro_noise[j], q);
      Vector6 accel;
      accel << T(s) * f + T(0.5 * s) * turned, f + turned;
      add_product(accel, T(node.noise_s) * accel_variance_[j], q);
    }
    for (int i = 0; i < kSensors; ++i) {
      const auto b = static_cast<std::size_t>(i / 3);
      const int j = i % 3;
      // A unit at the node is 1/left of what a unit at the beginning has left there. The noise of a
      // step is as dt (1 − dt/τ).
      const T variance = (T(node.noise_s) - T(node.longer_s2) / noise_.tau_s[i]) * noise_rate_[i] /
                         (at.left[i] * at.left[i]);
      const auto add = [&](const auto& effect) {
        add_product(effect, variance, q);
        for (int k = 0; k < effect.size(); ++k)
          q.with_sensors(k, i) += variance * now_.left[i] * effect[k];
      };
      if (b % 2 == 0) {
        const Vector3 a = at.attitude[b / 2].col(j);
        Vector9 gyro;
        gyro << position[b].col(j) - position[kTilt] * a, velocity[b].col(j) - velocity[kTilt] * a,
            now_.attitude[b / 2].col(j) - a;
        add(gyro);
      } else {
        Vector6 accel;
        accel << position[b].col(j), velocity[b].col(j);
        add(accel);
      }
    }
  }

  /// Position, velocity and attitude about local level to errors of the state.
  void to_errors(T* e) const {
    e[0] *= earth_.north_scale;
    e[1] *= earth_.east_scale;
    const Vector3 about_unit = now_.axes.transpose() * Vector3(e[6], e[7], e[8]);
    for (int i = 0; i < 3; ++i) e[6 + i] = about_unit[i];
  }

  const LocalTangentPlane& plane_;
  InsNoise<T> noise_;
  Vector3 gyro_variance_, accel_variance_;  ///< of a second
  double nominal_dt_s_;
  Vector12 kept_, noise_rate_;  ///< of sensor errors, in a nominal step and a second
  EarthAt<T> earth_;            ///< at the latest node
  State x_;
  Sums now_;
  Matrix3 turned_, turned_s_;  ///< a velocity error at the beginning, and its integral
  std::size_t nodes_ = 0;
  std::array<Node, kMostPanels + 1> node_;
};

}  // namespace wayfare::fitness_kernels
