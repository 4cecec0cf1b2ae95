#pragma once

#include <Eigen/Core>

#include <wayfare/inertial/detail/padded_vector.hpp>

namespace wayfare {

/// Detects rest from the deviations of rate and specific force from their own averages.
template <class T>
class RestDetector {
 public:
  using Vector = Eigen::Matrix<T, 3, 1>;
  using Padded = PaddedVector<T>;

  /// Largest deviation from the average at rest: rad/s and m/s².
  RestDetector(T rate_limit, T force_limit) : rate_limit_(rate_limit), force_limit_(force_limit) {}

  void add_rate(const Padded& rate, T dt) { rate_.add(rate, dt, rate_limit_); }
  void add_force(const Padded& force, T dt) { force_.add(force, dt, force_limit_); }
  void reset() { rate_.still_s = force_.still_s = T(0); }

  /// For how long both have been still, s.
  [[nodiscard]] T still_s() const {
    return rate_.still_s < force_.still_s ? rate_.still_s : force_.still_s;
  }
  [[nodiscard]] Vector mean_rate() const { return rate_.mean.unpadded(); }

 private:
  struct Follower {
    Padded mean;
    T still_s = T(0);

    void add(const Padded& x, T dt, T limit) {
      const Padded off = x - mean;
      still_s = off.squaredNorm() < limit * limit ? still_s + dt : T(0);
      mean += off * (dt / (T(0.5) + dt));  // half a second
    }
  };

  T rate_limit_, force_limit_;
  Follower rate_, force_;
};

}  // namespace wayfare
