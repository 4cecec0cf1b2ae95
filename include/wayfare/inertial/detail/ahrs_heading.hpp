#pragma once

// Heading of the AHRS from the magnetometer, where it measures the Earth's field.

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/ahrs_filter.hpp>
#include <wayfare/inertial/detail/padded_vector.hpp>

namespace wayfare {

/// Detects magnetic disturbances by the field's strength and dip, which do not depend on the
/// heading, and learns both.
template <class T>
class MagneticGate {
 public:
  using Padded = PaddedVector<T>;
  /// Horizontal and downward component, µT.
  using Shape = Eigen::Matrix<T, 2, 1>;

  explicit MagneticGate(const AhrsParameters& p)
      : lowest2_(T((1.0 - p.field_norm_gate) * (1.0 - p.field_norm_gate))),
        highest2_(T((1.0 + p.field_norm_gate) * (1.0 + p.field_norm_gate))),
        sin2_dip_gate_(T(std::pow(std::sin(p.field_dip_gate.radians()), 2))),
        settle_s_(T(p.field_settle_s)),
        relearn_s_(T(p.field_relearn_s)) {
    if (!(p.field_norm_uT > 0.0)) return;
    given_ = known_ = true;
    learned_s_ = relearn_s_;
    const double dip = p.field_dip.radians();
    earth_ = Shape(T(p.field_norm_uT * std::cos(dip)), T(p.field_norm_uT * std::sin(dip)));
  }

  enum class Field {
    earth,      ///< accepted for long enough
    settling,   ///< accepted recently
    disturbed,  ///< not the Earth's
  };

  /// Classifies a reading in world axes (z up). `turning`: only a field that is constant while the
  /// body turns is external to the body.
  Field update(const Padded& field_enu, T dt, bool turning) {
    // Averaged in world axes, where the Earth's field is constant.
    mean_ = started_ ? Padded(mean_ + (field_enu - mean_) * (dt / (T(0.05) + dt))) : field_enu;
    started_ = true;
    const Shape shape(mean_.template head<2>().norm(), -mean_.z());
    if (!known_) {
      earth_ = shape;
      known_ = true;
    }
    if (!alike(shape, earth_)) {
      undisturbed_s_ = T(0);
      update_candidate(shape, dt, turning);
      return Field::disturbed;
    }
    undisturbed_s_ += dt;
    candidate_s_ = T(0);
    learned_s_ = std::min(learned_s_ + dt, relearn_s_);
    if (!given_ && dt > T(0)) earth_ += (shape - earth_) * (dt / (learned_s_ + dt));
    return undisturbed_s_ > settle_s_ ? Field::earth : Field::settling;
  }

  /// To call when the world axes were rotated.
  void forget_average() { started_ = false; }

  /// Reference field; zero before the first reading.
  [[nodiscard]] const Shape& earth() const { return earth_; }
  /// Number of times the reference was replaced.
  [[nodiscard]] int relearned() const { return relearned_; }

 private:
  [[nodiscard]] bool alike(const Shape& a, const Shape& b) const {
    const T a2 = a.squaredNorm(), b2 = b.squaredNorm();
    const T sine = a.x() * b.y() - a.y() * b.x();
    return a2 > lowest2_ * b2 && a2 < highest2_ * b2 && sine * sine < sin2_dip_gate_ * a2 * b2 &&
           a.dot(b) > T(0);
  }

  void update_candidate(const Shape& shape, T dt, bool turning) {
    if (candidate_s_ == T(0) || !alike(shape, candidate_)) {
      candidate_ = shape;
      candidate_s_ = dt;
      return;
    }
    candidate_ += (shape - candidate_) * (dt / (T(1) + dt));
    if (turning) candidate_s_ += dt;
    // A reference known for a short time only is replaced as soon.
    if (candidate_s_ <= std::clamp(learned_s_, T(2), relearn_s_)) return;
    earth_ = candidate_;
    learned_s_ = candidate_s_ = T(0);
    ++relearned_;
  }

  T lowest2_, highest2_, sin2_dip_gate_, settle_s_, relearn_s_;
  bool given_ = false, known_ = false, started_ = false;
  Shape earth_ = Shape::Zero(), candidate_ = Shape::Zero();
  Padded mean_;
  T undisturbed_s_ = T(0), candidate_s_ = T(0), learned_s_ = T(0);
  int relearned_ = 0;
};

template <class T>
class AhrsHeading {
 public:
  using Padded = PaddedVector<T>;
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
    filter.turn_heading(angle, sigma);
    gate_.forget_average();
    lost_s_ = T(0);
    known_ = true;
  }

  /// `field` in the filter's world axes, mean over dt, `rate` of the body with its bias subtracted.
  Outcome update(Filter& filter, const Padded& field, const Padded& rate, T dt) {
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
    observe(filter, field, filter.in_world(rate), off, dt);
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

  void observe(Filter& filter, const Padded& field, const Padded& world_rate, T off, T dt) {
    // Derivative by the delay: dm = −ω×m.
    const Padded change = field.cross(world_rate);
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
