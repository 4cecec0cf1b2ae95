#pragma once

#include <cmath>

#include <wayfare/inertial/ahrs_parameters.hpp>

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

}  // namespace wayfare
