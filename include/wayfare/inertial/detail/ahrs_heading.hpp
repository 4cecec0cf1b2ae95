#pragma once

// Heading of the AHRS from the magnetometer, where it measures the Earth's field.

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/ahrs_alignment.hpp>
#include <wayfare/inertial/detail/ahrs_filter.hpp>
#include <wayfare/inertial/detail/magnetic_gate.hpp>

namespace wayfare {

template <class T>
class AhrsHeading {
 public:
  using Vector = Eigen::Matrix<T, 3, 1>;
  using Filter = AhrsFilter<T>;

  struct Outcome {
    UpdateStatus status = UpdateStatus::used;
    bool reset = false;  ///< the heading was lost and was reset to the field
  };

  explicit AhrsHeading(const AhrsParameters& p)
      : gate_(p),
        declination_(T(p.declination.radians())),
        density2_(T(p.heading_density * p.heading_density)),
        lost_heading_(T(p.lost_heading.radians())),
        lost_heading_s_(T(p.lost_heading_s)) {}

  [[nodiscard]] bool known() const { return known_; }
  void forget() { known_ = false; }
  void set(Filter& filter, Angle x_axis, Angle sigma) {
    const Angle now = compass_of_x<frame::Enu>(filter.q_enu_body());
    reset(filter, T((now - x_axis).radians()), T(sigma.radians()));
  }
  /// Rotates the heading counter-clockwise; it then has standard deviation `sigma`.
  void reset(Filter& filter, T angle, T sigma) {
    align::turn_heading(filter, angle, sigma);
    gate_.forget_average();
    lost_s_ = T(0);
    known_ = true;
  }

  /// `field` in the filter's world axes, `rate` of the body with its bias subtracted.
  Outcome update(Filter& filter, const Vector& field, const Vector& rate, T dt) {
    // Without the tilt the dip of the field is unknown.
    const auto& p = filter.covariance();
    if (p(0, 0) + p(1, 1) > T(2) * kLevel * kLevel) return {UpdateStatus::waiting};
    constexpr T kTurning = T(0.35);  // 20 °/s
    const auto verdict = gate_.update(field, dt, rate.squaredNorm() > kTurning * kTurning);
    const T level2 = field.template head<2>().squaredNorm();
    constexpr T kLeastLevel2 = T(0.0025);  // dip above 87°: too close to a magnetic pole
    if (level2 < kLeastLevel2 * field.squaredNorm()) return {UpdateStatus::disturbed};
    const T off = wrap_to_pi(std::atan2(field.x(), field.y()) - declination_);
    if (!known_) {
      initialise(filter, off, level2 / (field.z() * field.z() + level2));
      return {UpdateStatus::used};
    }
    using Field = typename MagneticGate<T>::Field;
    if (verdict == Field::disturbed) return {UpdateStatus::disturbed};
    if (verdict == Field::settling || !(dt > T(0))) return {UpdateStatus::waiting};
    observe(filter, field, filter.rotation() * rate, off, dt);
    return {UpdateStatus::used, reset_if_lost(filter, off, dt)};
  }

  [[nodiscard]] const MagneticGate<T>& gate() const { return gate_; }
  /// Normalised innovation squared of the last reading used.
  [[nodiscard]] T nis() const { return nis_; }

 private:
  static constexpr T kSigma = T(0.17);  // of a heading from one reading
  static constexpr T kLevel = T(0.07);  // 4°: sufficient to compute the dip
  static constexpr T kLargestDelay = T(0.1);

  void initialise(Filter& filter, T off, T level_part2) {
    // A tilt error rotates the field's vertical part into the horizontal.
    const auto& p = filter.covariance();
    const T from_level2 = (p(0, 0) + p(1, 1)) * T(0.5) * (T(1) / level_part2 - T(1));
    reset(filter, off, std::sqrt(kSigma * kSigma + from_level2));
  }

  void observe(Filter& filter, const Vector& field, const Vector& world_rate, T off, T dt) {
    // Derivative by the delay: dm = −ω×m.
    const Vector change = -world_rate.cross(field);
    const T by_delay =
        (field.y() * change.x() - field.x() * change.y()) / field.template head<2>().squaredNorm();
    nis_ = filter.observe(IndexedRow<T, 2, 8>{{T(1), -by_delay}}, off, density2_ / dt);
    filter.apply();
    filter.set_delay(std::clamp(filter.delay(), -kLargestDelay, kLargestDelay));
  }

  bool reset_if_lost(Filter& filter, T off, T dt) {
    lost_s_ = std::abs(off) > lost_heading_ ? lost_s_ + dt : T(0);
    if (lost_s_ < lost_heading_s_) return false;
    reset(filter, off, kSigma);
    return true;
  }

  MagneticGate<T> gate_;
  T declination_, density2_, lost_heading_, lost_heading_s_;
  T lost_s_ = T(0);
  T nis_ = std::numeric_limits<T>::quiet_NaN();
  bool known_ = false;
};

}  // namespace wayfare
