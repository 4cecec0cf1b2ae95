#pragma once

// What gives the AHRS its heading: the magnetometer, as far as it reads the Earth's field.

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
    bool taken_anew = false;  ///< the heading was lost and was taken from the field
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
    turn(filter, T((now - x_axis).radians()), T(sigma.radians()));
  }
  /// Counter-clockwise, to a heading that is then known to `sigma`.
  void turn(Filter& filter, T angle, T sigma) {
    align::turn_heading(filter, angle, sigma);
    gate_.forget_average();
    lost_s_ = T(0);
    known_ = true;
  }

  /// `field` in world axes as the filter sees it, `rate` of the body with its bias taken off.
  Outcome take(Filter& filter, const Vector& field, const Vector& rate, T dt) {
    // As long as the level is not known the field's dip is not either.
    const auto& p = filter.covariance();
    if (p(0, 0) + p(1, 1) > T(2) * kLevel * kLevel) return {UpdateStatus::waiting};
    constexpr T kTurning = T(0.35);  // 20 °/s
    const auto verdict = gate_.take(field, dt, rate.squaredNorm() > kTurning * kTurning);
    const T level2 = field.template head<2>().squaredNorm();
    constexpr T kLeastLevel2 = T(0.0025);  // steeper than 87°: too near a magnetic pole
    if (level2 < kLeastLevel2 * field.squaredNorm()) return {UpdateStatus::disturbed};
    const T off = wrap_to_pi(std::atan2(field.x(), field.y()) - declination_);
    if (!known_) {
      take_as_it_is(filter, off, level2 / (field.z() * field.z() + level2));
      return {UpdateStatus::used};
    }
    using Field = typename MagneticGate<T>::Field;
    if (verdict == Field::disturbed) return {UpdateStatus::disturbed};
    if (verdict == Field::settling || !(dt > T(0))) return {UpdateStatus::waiting};
    observe(filter, field, filter.rotation() * rate, off, dt);
    return {UpdateStatus::used, find_again(filter, off, dt)};
  }

  [[nodiscard]] const MagneticGate<T>& gate() const { return gate_; }
  /// Of the last reading used: squared innovation over its variance.
  [[nodiscard]] T nis() const { return nis_; }

 private:
  static constexpr T kSigma = T(0.17);  // of a heading taken from one reading
  static constexpr T kLevel = T(0.07);  // 4°: well enough known for a dip
  static constexpr T kLargestDelay = T(0.1);

  void take_as_it_is(Filter& filter, T off, T level_part2) {
    // A level that is off by an angle tilts the field into the horizontal by its dip.
    const auto& p = filter.covariance();
    const T from_level2 = (p(0, 0) + p(1, 1)) * T(0.5) * (T(1) / level_part2 - T(1));
    turn(filter, off, std::sqrt(kSigma * kSigma + from_level2));
  }

  void observe(Filter& filter, const Vector& field, const Vector& world_rate, T off, T dt) {
    // Were the delay longer, the field would be turned back further: dm = −ω×m.
    const Vector change = -world_rate.cross(field);
    const T by_delay =
        (field.y() * change.x() - field.x() * change.y()) / field.template head<2>().squaredNorm();
    nis_ = filter.observe(IndexedRow<T, 2, 8>{{T(1), -by_delay}}, off, density2_ / dt);
    filter.apply();
    filter.set_delay(std::clamp(filter.delay(), -kLargestDelay, kLargestDelay));
  }

  bool find_again(Filter& filter, T off, T dt) {
    lost_s_ = std::abs(off) > lost_heading_ ? lost_s_ + dt : T(0);
    if (lost_s_ < lost_heading_s_) return false;
    turn(filter, off, kSigma);
    return true;
  }

  MagneticGate<T> gate_;
  T declination_, density2_, lost_heading_, lost_heading_s_;
  T lost_s_ = T(0);
  T nis_ = std::numeric_limits<T>::quiet_NaN();
  bool known_ = false;
};

}  // namespace wayfare
