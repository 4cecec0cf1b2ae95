#pragma once

// Levelling of the AHRS: bounded velocity, rest, and recovery of a wrong attitude.

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Core>

#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/detail/ahrs_filter.hpp>
#include <wayfare/inertial/detail/rest_detector.hpp>

namespace wayfare {

/// Zero-mean first-order Gauss-Markov velocity as a measurement for a filter that integrates the
/// acceleration. From v₁ = φ·v₀ + w with φ = exp(−dt/τ) and v₁ = v₀ + a·dt: the innovation w,
/// divided by 1 − φ, is v₁ + a·dt·φ/(1 − φ), white, of variance σ²(1 + φ)/(1 − φ). The model is one
/// measurement of zero per step, exact at any rate.
template <class T>
class HorizontalVelocityModel {
 public:
  explicit HorizontalVelocityModel(const AhrsParameters& p)
      : time_s_(T(p.velocity_time_s)),
        variance_(T(p.velocity_density * p.velocity_density / (2.0 * p.velocity_time_s))) {}

  void set_step(T dt) {
    if (dt == dt_) return;
    dt_ = dt;
    const T one_minus_phi = -std::expm1(-dt / time_s_);
    const T phi = T(1) - one_minus_phi;
    acceleration_gain_s_ = dt * phi / one_minus_phi;
    innovation_variance_ = variance_ * (T(1) + phi) / one_minus_phi;
  }

  /// Factor of the acceleration in the measurement, dt·φ/(1 − φ), s.
  [[nodiscard]] T acceleration_gain_s() const { return acceleration_gain_s_; }
  [[nodiscard]] T innovation_variance() const { return innovation_variance_; }
  /// σ² of the process, m²/s².
  [[nodiscard]] T variance() const { return variance_; }

 private:
  T time_s_, variance_;
  T dt_ = T(0), acceleration_gain_s_ = T(0), innovation_variance_ = T(0);
};

template <class T>
class AhrsLevel {
 public:
  using Vector = Eigen::Matrix<T, 3, 1>;
  using Padded = PaddedVector<T>;
  using Filter = AhrsFilter<T>;

  explicit AhrsLevel(const AhrsParameters& p)
      : velocity_model_(p),
        rest_(T(p.rest_rate), T(p.rest_force)),
        rest_time_s_(T(p.rest_time_s)),
        rest_bias_limit2_(T(p.rest_bias_limit * p.rest_bias_limit)),
        rest_rate2_(T(p.rest_rate_density * p.rest_rate_density)),
        rest_velocity2_(T(p.rest_velocity_density * p.rest_velocity_density)),
        lost_level_(T(p.lost_level)),
        lost_level_at_rest_(T(p.lost_level_at_rest)) {}

  /// Initial attitude from one reading close to gravity: good to 2° at rest, and less in motion.
  bool start(Filter& filter, const Vector& force, const Vector& rate) {
    const T off = force.norm() / T(kGravity) - T(1);
    if (!(std::abs(off) < T(0.5))) return false;
    const T turning = rate.norm() > T(0.3) ? T(0.4) : T(0);
    filter.set_attitude(SO3<T>());
    filter.level(force, std::sqrt(T(0.0012) + T(9) * off * off + turning * turning));
    reset_velocity(filter);
    return true;
  }

  /// Forgets the velocity, after a gap.
  void reset_velocity(Filter& filter) {
    filter.forget_velocity(velocity_model_.variance());
    mean_.setZero();
    lost_s_ = T(0);
    since_ = {};
  }

  void add_rate(const Padded& rate, T dt) { rest_.add_rate(rate, dt); }

  /// Adds the specific force, in body and world axes, and levels the filter by it where that is
  /// due. Returns whether a wrong attitude was levelled again.
  bool add_force(Filter& filter, const Padded& body, const Padded& world, T dt, T variance) {
    rest_.add_force(body, dt);
    since_.velocity += world * dt;
    since_.span_s += dt;
    since_.variance += variance;
    since_.body = body;
    return since_.span_s > Filter::kUpdate_s && settle(filter);
  }
  /// Forgets the force since then: the world axes were rotated.
  void skip() { since_ = {}; }
  /// Propagates the filter by the force since it was last levelled, and levels it.
  bool settle(Filter& filter) {
    const Since since = std::exchange(since_, {});
    if (!(since.span_s > T(0))) return false;
    const Padded force = since.velocity / since.span_s;
    filter.propagate();
    filter.accelerate(force, since.span_s, since.variance);
    update_velocity(filter, force, since.span_s);
    since_rest_s_ += since.span_s;
    if (since_rest_s_ > T(0.05)) {
      if (at_rest()) update_at_rest(filter, since_rest_s_);
      since_rest_s_ = T(0);
    }
    filter.apply();
    return relevel_if_lost(filter, since.body, force, since.span_s);
  }

  [[nodiscard]] bool at_rest() const {
    return rest_.still_s() > rest_time_s_ && rest_.mean_rate().squaredNorm() < rest_bias_limit2_;
  }
  void forget_rest() { rest_.reset(); }
  /// Normalised innovations squared of the last reading, east and north.
  [[nodiscard]] const std::array<T, 2>& nis() const { return nis_; }

 private:
  template <int... Index>
  using Row = IndexedRow<T, Index...>;
  static constexpr double kGravity = 9.80665;
  struct Since {
    Padded velocity;  // ∫ force, world axes
    Padded body;      // the latest force
    T span_s = T(0), variance = T(0);
  };

  /// The velocity model as a measurement: v + k·a is white noise.
  void update_velocity(Filter& filter, const Padded& f, T dt) {
    velocity_model_.set_step(dt);
    const T k = velocity_model_.acceleration_gain_s(), r = velocity_model_.innovation_variance();
    const auto& v = filter.velocity();
    nis_[0] = filter.observe(Row<1, 2, 6>{{k * f.z(), -k * f.y(), T(1)}}, -(v.x() + k * f.x()), r);
    nis_[1] = filter.observe(Row<0, 2, 7>{{-k * f.z(), k * f.x(), T(1)}}, -(v.y() + k * f.y()), r);
  }

  /// At rest the gyro reads its bias and the velocity is zero.
  void update_at_rest(Filter& filter, T elapsed) {
    const Vector off = rest_.mean_rate() - filter.bias();
    for (int i = 0; i < 3; ++i) {
      // A slow steady rotation is not a bias.
      const T expected = filter.covariance()(3 + i, 3 + i) + T(2) * rest_rate2_;
      if (off[i] * off[i] > T(16) * expected) return;
    }
    filter.observe(Row<3>{{T(1)}}, off.x(), rest_rate2_ / elapsed);
    filter.observe(Row<4>{{T(1)}}, off.y(), rest_rate2_ / elapsed);
    filter.observe(Row<5>{{T(1)}}, off.z(), rest_rate2_ / elapsed);
    filter.observe(Row<6>{{T(1)}}, -filter.velocity().x(), rest_velocity2_ / elapsed);
    filter.observe(Row<7>{{T(1)}}, -filter.velocity().y(), rest_velocity2_ / elapsed);
  }

  /// If the mean force does not point up for half a second the attitude is wrong; upside down is
  /// otherwise an equilibrium.
  bool relevel_if_lost(Filter& filter, const Padded& body, const Padded& world, T dt) {
    mean_ += (world - mean_) * (dt / (T(1) + dt));
    const T limit = rest_.still_s() > T(0.5) ? lost_level_at_rest_ : lost_level_;
    const bool tilted = mean_.template head<2>().squaredNorm() > limit * limit;
    lost_s_ = tilted || mean_.z() < -limit ? lost_s_ + dt : T(0);
    if (lost_s_ < T(0.5) || std::abs(body.norm() - T(kGravity)) > T(0.3 * kGravity)) return false;
    filter.level(body.unpadded(), T(0.3));
    reset_velocity(filter);
    return true;
  }

  HorizontalVelocityModel<T> velocity_model_;
  RestDetector<T> rest_;
  T rest_time_s_, rest_bias_limit2_, rest_rate2_, rest_velocity2_, lost_level_, lost_level_at_rest_;
  Padded mean_;  ///< specific force in world axes, averaged over a second
  Since since_;  ///< levelled last
  T lost_s_ = T(0), since_rest_s_ = T(0);
  std::array<T, 2> nis_{std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::quiet_NaN()};
};

}  // namespace wayfare
