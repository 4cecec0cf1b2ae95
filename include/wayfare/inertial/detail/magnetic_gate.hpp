#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include <wayfare/inertial/ahrs_parameters.hpp>

namespace wayfare {

/// Detects magnetic disturbances by the field's strength and dip, which do not depend on the
/// heading, and learns both.
template <class T>
class MagneticGate {
 public:
  using Vector = Eigen::Matrix<T, 3, 1>;
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
  Field update(const Vector& field_enu, T dt, bool turning) {
    // Averaged in world axes, where the Earth's field is constant.
    mean_ = started_ ? Vector(mean_ + (field_enu - mean_) * (dt / (T(0.05) + dt))) : field_enu;
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
  Vector mean_ = Vector::Zero();
  T undisturbed_s_ = T(0), candidate_s_ = T(0), learned_s_ = T(0);
  int relearned_ = 0;
};

}  // namespace wayfare
