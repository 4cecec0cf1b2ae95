#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/detail/stumpff.hpp>
#include <wayfare/core/manifold.hpp>

namespace wayfare {

/// The matrix of the cross product with `v`.
template <class T>
[[nodiscard]] Eigen::Matrix<T, 3, 3> skew(const Eigen::Matrix<T, 3, 1>& v) {
  return (Eigen::Matrix<T, 3, 3>() << T(0), -v[2], v[1], v[2], T(0), -v[0], -v[1], v[0], T(0))
      .finished();
}

/// A rotation of space, stored as a unit quaternion. Tangent vectors are rotation vectors, radians.
template <class T>
class SO3 {
 public:
  using Scalar = T;                         ///< floating point, pack or dual number
  static constexpr int kDof = 3;            ///< dimension of the tangent space
  using Tangent = Eigen::Matrix<T, 3, 1>;   ///< rotation vector
  using Jacobian = Eigen::Matrix<T, 3, 3>;  ///< of maps between tangents
  using Vector = Eigen::Matrix<T, 3, 1>;    ///< of space
  using Quaternion = Eigen::Quaternion<T>;  ///< w, x, y, z

  SO3() = default;
  /// Normalises `q`, which must not be zero.
  explicit SO3(const Quaternion& q) : q_(q) {
    using std::sqrt;
    q_.coeffs() /= sqrt(q.squaredNorm());
  }
  /// From an orthogonal matrix of determinant 1.
  explicit SO3(const Eigen::Matrix<T, 3, 3>& rotation) : SO3(Quaternion(rotation)) {}

  /// No rotation.
  [[nodiscard]] static SO3 identity() { return SO3(); }
  /// Of a quaternion that has unit length but for rounding.
  [[nodiscard]] static SO3 from_unit(const Quaternion& q) {
    SO3 r;
    r.q_ = q;
    return r;
  }
  /// The shortest rotation from the direction of `from` to that of `to`, both nonzero; for opposite
  /// directions, any one of them.
  [[nodiscard]] static SO3 between(const Vector& from, const Vector& to) {
    using std::sqrt;
    const T length = sqrt(from.squaredNorm() * to.squaredNorm()), w = length + from.dot(to);
    if (w > T(8) * std::numeric_limits<T>::epsilon() * length) {
      const Vector axis = from.cross(to);
      return SO3(Quaternion(w, axis[0], axis[1], axis[2]));
    }
    const Vector axis = from.unitOrthogonal();
    return SO3(Quaternion(T(0), axis[0], axis[1], axis[2]));
  }

  /// Of unit length.
  [[nodiscard]] const Quaternion& quaternion() const { return q_; }
  /// Orthogonal.
  [[nodiscard]] Eigen::Matrix<T, 3, 3> matrix() const { return q_.toRotationMatrix(); }

  /// The opposite rotation.
  [[nodiscard]] SO3 inverse() const { return from_unit(q_.conjugate()); }
  /// `o`, then this rotation.
  SO3 operator*(const SO3& o) const {
    // One Newton step towards unit norm keeps long products on the sphere.
    Quaternion q = q_ * o.q_;
    q.coeffs() *= T(1.5) - T(0.5) * q.squaredNorm();
    return from_unit(q);
  }
  /// Rotates a vector.
  Vector operator*(const Vector& v) const { return q_ * v; }

  /// (101).
  [[nodiscard]] static SO3 exp(const Tangent& tau) {
    const T quarter = T(0.25) * tau.squaredNorm();
    const T k = T(0.5) * stumpff<1>(quarter);
    return from_unit(Quaternion(stumpff<0>(quarter), k * tau[0], k * tau[1], k * tau[2]));
  }
  /// (102), the shorter of the two rotation vectors.
  [[nodiscard]] Tangent log() const {
    using std::atan2, std::sqrt;
    const T sign = q_.w() < T(0) ? T(-1) : T(1);
    const T w = sign * q_.w();
    const Vector v = sign * q_.vec();
    const T square = v.squaredNorm();
    if (square < T(1e-8)) return (T(2) / w) * (T(1) - square / (T(3) * w * w)) * v;
    const T norm = sqrt(square);
    return (T(2) * atan2(norm, w) / norm) * v;
  }

  /// The matrix itself.
  [[nodiscard]] Jacobian adjoint() const { return matrix(); }

  /// (143).
  [[nodiscard]] static Jacobian right_jacobian(const Tangent& tau) {
    const T square = tau.squaredNorm();
    const Jacobian k = skew(tau);
    return Jacobian::Identity() - stumpff<2>(square) * k + stumpff<3>(square) * k * k;
  }
  /// (144).
  [[nodiscard]] static Jacobian right_jacobian_inverse(const Tangent& tau) {
    const T square = tau.squaredNorm();
    // 1/θ² − (1 + cos θ)/(2θ sin θ) = (c₃ − 2c₄)/(2c₂), which is regular at both zero and π.
    const T c = (stumpff<3>(square) - T(2) * stumpff<4>(square)) / (T(2) * stumpff<2>(square));
    const Jacobian k = skew(tau);
    return Jacobian::Identity() + T(0.5) * k + c * k * k;
  }

  /// x exp τ.
  [[nodiscard]] SO3 plus(const Tangent& tau) const { return *this * exp(tau); }
  /// τ in x exp τ = *this.
  [[nodiscard]] Tangent minus(const SO3& x) const { return (x.inverse() * *this).log(); }

  /// In another scalar.
  template <class U>
  [[nodiscard]] SO3<U> cast() const {
    return SO3<U>(q_.template cast<U>());
  }

 private:
  Quaternion q_ = Quaternion::Identity();
};

using SO3d = SO3<double>;  ///< of double

/// Rz(yaw) Ry(pitch) Rx(roll), radians; for `q_nb` the vehicle's attitude angles.
[[nodiscard]] inline SO3d rotation_from_roll_pitch_yaw(const Eigen::Vector3d& roll_pitch_yaw_rad) {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  return SO3d(Eigen::Quaterniond(AngleAxisd(roll_pitch_yaw_rad[2], Vector3d::UnitZ()) *
                                 AngleAxisd(roll_pitch_yaw_rad[1], Vector3d::UnitY()) *
                                 AngleAxisd(roll_pitch_yaw_rad[0], Vector3d::UnitX())));
}

/// Roll and yaw in [−π, π], pitch in [−π/2, π/2]. At pitch ±π/2, where roll and yaw rotate about
/// the same axis, only yaw − roll (up) or yaw + roll (down) is determined: roll is then 0 by
/// convention. At any pitch `rotation_from_roll_pitch_yaw` of the angles is the rotation, within
/// rounding.
[[nodiscard]] inline Eigen::Vector3d roll_pitch_yaw_rad(const SO3d& rotation) {
  constexpr double kStraight = 1e-12;  // cosine of a pitch at which roll would be rounding
  const Eigen::Matrix3d r = rotation.matrix();
  const double cos_pitch = std::hypot(r(2, 1), r(2, 2));
  const double roll = cos_pitch < kStraight ? 0.0 : std::atan2(r(2, 1), r(2, 2));
  // From the rotation without the roll: near pitch ±π/2 its second column determines yaw better
  // than its first.
  const double s = std::sin(roll), c = std::cos(roll);
  const double yaw = std::atan2(s * r(0, 2) - c * r(0, 1), c * r(1, 1) - s * r(1, 2));
  return {roll, std::atan2(-r(2, 0), cos_pitch), yaw};
}

/// A rigid motion of space. Tangent vectors are (ρ, θ): three metres, then three radians.
template <class T>
class SE3 {
 public:
  using Scalar = T;                         ///< floating point, pack or dual number
  static constexpr int kDof = 6;            ///< dimension of the tangent space
  using Tangent = Eigen::Matrix<T, 6, 1>;   ///< (ρ, θ)
  using Jacobian = Eigen::Matrix<T, 6, 6>;  ///< of maps between tangents
  using Vector = Eigen::Matrix<T, 3, 1>;    ///< a point
  using Block = Eigen::Matrix<T, 3, 3>;     ///< a block of a Jacobian

  SE3() = default;
  /// First the rotation, then the translation.
  SE3(const Vector& translation, const SO3<T>& rotation)
      : translation_(translation), rotation_(rotation) {}

  /// No motion.
  [[nodiscard]] static SE3 identity() { return SE3(); }

  /// Metres.
  [[nodiscard]] const Vector& translation() const { return translation_; }
  /// Applied before the translation.
  [[nodiscard]] const SO3<T>& rotation() const { return rotation_; }

  /// The inverse motion.
  [[nodiscard]] SE3 inverse() const {
    const SO3<T> r = rotation_.inverse();
    return SE3(Vector(-(r * translation_)), r);
  }
  /// `o`, then this motion.
  SE3 operator*(const SE3& o) const {
    return SE3(Vector(translation_ + rotation_ * o.translation_), rotation_ * o.rotation_);
  }
  /// Moves a point.
  Vector operator*(const Vector& p) const { return translation_ + rotation_ * p; }

  /// (172), V(θ) = Jl(θ) = Jr(−θ).
  [[nodiscard]] static SE3 exp(const Tangent& tau) {
    const Vector theta = tau.template tail<3>();
    return SE3(Vector(SO3<T>::right_jacobian(-theta) * tau.template head<3>()), SO3<T>::exp(theta));
  }
  /// (173).
  [[nodiscard]] Tangent log() const {
    const Vector theta = rotation_.log();
    Tangent tau;
    tau.template head<3>() = SO3<T>::right_jacobian_inverse(-theta) * translation_;
    tau.template tail<3>() = theta;
    return tau;
  }

  /// (175).
  [[nodiscard]] Jacobian adjoint() const {
    const Block r = rotation_.matrix();
    return upper_triangular(r, skew(translation_) * r);
  }

  /// (179a) at −τ.
  [[nodiscard]] static Jacobian right_jacobian(const Tangent& tau) {
    const Block j = SO3<T>::right_jacobian(tau.template tail<3>());
    return upper_triangular(j, left_coupling(-tau));
  }
  /// (179b) at −τ.
  [[nodiscard]] static Jacobian right_jacobian_inverse(const Tangent& tau) {
    const Block j = SO3<T>::right_jacobian_inverse(tau.template tail<3>());
    return upper_triangular(j, -j * left_coupling(-tau) * j);
  }

  /// x exp τ.
  [[nodiscard]] SE3 plus(const Tangent& tau) const { return *this * exp(tau); }
  /// τ in x exp τ = *this.
  [[nodiscard]] Tangent minus(const SE3& x) const { return (x.inverse() * *this).log(); }

  /// In another scalar.
  template <class U>
  [[nodiscard]] SE3<U> cast() const {
    return SE3<U>(translation_.template cast<U>(), rotation_.template cast<U>());
  }

 private:
  static Jacobian upper_triangular(const Block& diagonal, const Block& corner) {
    Jacobian result = Jacobian::Zero();
    result.template topLeftCorner<3, 3>() = diagonal;
    result.template topRightCorner<3, 3>() = corner;
    result.template bottomRightCorner<3, 3>() = diagonal;
    return result;
  }
  /// Q(ρ, θ) of (180).
  static Block left_coupling(const Tangent& tau) {
    const Vector theta = tau.template tail<3>();
    const Block v = skew(Vector(tau.template head<3>()));
    const Block w = skew(theta);
    const T square = theta.squaredNorm();
    // (θ − sin θ)/θ³, (1 − θ²/2 − cos θ)/θ⁴, (θ − sin θ − θ³/6)/θ⁵
    const T a = stumpff<3>(square), b = -stumpff<4>(square), c = -stumpff<5>(square);
    const Block wv = w * v, vw = v * w, wvw = wv * w;
    return T(0.5) * v + a * (wv + vw + wvw) - b * (w * wv + vw * w - T(3) * wvw) -
           T(0.5) * (b - T(3) * c) * (wvw * w + w * wvw);
  }

  Vector translation_ = Vector::Zero();
  SO3<T> rotation_{};
};

using SE3d = SE3<double>;  ///< of double

}  // namespace wayfare
