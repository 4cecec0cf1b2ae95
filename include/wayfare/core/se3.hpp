#pragma once

#include <Eigen/Core>

#include <wayfare/core/detail/stumpff.hpp>
#include <wayfare/core/so3.hpp>

namespace wayfare {

/// A rigid motion of space. Tangent vectors are (ρ, θ): three metres, then three radians.
template <class T>
class SE3 {
 public:
  using Scalar = T;
  static constexpr int kDof = 6;
  using Tangent = Eigen::Matrix<T, 6, 1>;
  using Jacobian = Eigen::Matrix<T, 6, 6>;
  using Vector = Eigen::Matrix<T, 3, 1>;
  using Block = Eigen::Matrix<T, 3, 3>;

  SE3() = default;
  SE3(const Vector& translation, const SO3<T>& rotation)
      : translation_(translation), rotation_(rotation) {}

  [[nodiscard]] static SE3 identity() { return SE3(); }

  [[nodiscard]] const Vector& translation() const { return translation_; }
  [[nodiscard]] const SO3<T>& rotation() const { return rotation_; }

  [[nodiscard]] SE3 inverse() const {
    const SO3<T> r = rotation_.inverse();
    return SE3(Vector(-(r * translation_)), r);
  }
  SE3 operator*(const SE3& o) const {
    return SE3(Vector(translation_ + rotation_ * o.translation_), rotation_ * o.rotation_);
  }
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

  [[nodiscard]] SE3 plus(const Tangent& tau) const { return *this * exp(tau); }
  [[nodiscard]] Tangent minus(const SE3& x) const { return (x.inverse() * *this).log(); }

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

using SE3d = SE3<double>;

}  // namespace wayfare
