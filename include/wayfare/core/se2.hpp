#pragma once

#include <cmath>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/detail/stumpff.hpp>
#include <wayfare/core/manifold.hpp>

namespace wayfare {

/// A rotation of the plane, counter-clockwise positive, stored as a unit complex number.
template <class T>
class SO2 {
 public:
  using Scalar = T;                         ///< floating point, pack or dual number
  static constexpr int kDof = 1;            ///< dimension of the tangent space
  using Tangent = Eigen::Matrix<T, 1, 1>;   ///< (θ), radians
  using Jacobian = Eigen::Matrix<T, 1, 1>;  ///< of maps between tangents
  using Vector = Eigen::Matrix<T, 2, 1>;    ///< a point of the plane

  SO2() = default;
  /// By an angle.
  explicit SO2(const BasicAngle<T>& angle) {
    using std::cos, std::sin;
    cos_ = cos(angle.radians());
    sin_ = sin(angle.radians());
  }
  template <BareNumber Bare>
  explicit SO2(Bare) = delete;  // a heading is an Angle: write 0.3_rad or Angle::degrees(17)

  /// No rotation.
  [[nodiscard]] static SO2 identity() { return SO2(); }
  /// By tau[0] radians.
  [[nodiscard]] static SO2 exp(const Tangent& tau) { return SO2(BasicAngle<T>::radians(tau[0])); }
  /// In (−π, π].
  [[nodiscard]] Tangent log() const { return Tangent(angle().radians()); }

  /// In (−π, π].
  [[nodiscard]] BasicAngle<T> angle() const {
    using std::atan2;
    return BasicAngle<T>::radians(atan2(sin_, cos_));
  }
  /// Of the angle.
  [[nodiscard]] const T& cos() const { return cos_; }
  /// Of the angle.
  [[nodiscard]] const T& sin() const { return sin_; }
  /// cos −sin; sin cos.
  [[nodiscard]] Eigen::Matrix<T, 2, 2> matrix() const {
    return (Eigen::Matrix<T, 2, 2>() << cos_, -sin_, sin_, cos_).finished();
  }

  /// The opposite rotation.
  [[nodiscard]] SO2 inverse() const { return SO2(cos_, -sin_); }
  /// By the sum of the angles.
  SO2 operator*(const SO2& o) const {
    // One Newton step towards unit norm keeps long products on the circle.
    const T c = cos_ * o.cos_ - sin_ * o.sin_;
    const T s = sin_ * o.cos_ + cos_ * o.sin_;
    const T scale = T(1.5) - T(0.5) * (c * c + s * s);
    return SO2(c * scale, s * scale);
  }
  /// Rotates a vector.
  Vector operator*(const Vector& v) const {
    return Vector(cos_ * v.x() - sin_ * v.y(), sin_ * v.x() + cos_ * v.y());
  }

  /// One: rotations of the plane commute.
  [[nodiscard]] Jacobian adjoint() const { return Jacobian::Ones(); }
  /// One.
  [[nodiscard]] static Jacobian right_jacobian(const Tangent&) { return Jacobian::Ones(); }
  /// One.
  [[nodiscard]] static Jacobian right_jacobian_inverse(const Tangent&) { return Jacobian::Ones(); }

  /// x exp τ.
  [[nodiscard]] SO2 plus(const Tangent& tau) const { return *this * exp(tau); }
  /// τ in x exp τ = *this.
  [[nodiscard]] Tangent minus(const SO2& x) const { return (x.inverse() * *this).log(); }

  /// In another scalar.
  template <class U>
  [[nodiscard]] SO2<U> cast() const {
    return SO2<U>::from_unit_complex(U(cos_), U(sin_));
  }
  /// `cos² + sin²` must be 1 to rounding.
  [[nodiscard]] static SO2 from_unit_complex(const T& cos, const T& sin) { return SO2(cos, sin); }

 private:
  SO2(const T& cos, const T& sin) : cos_(cos), sin_(sin) {}

  T cos_{1};
  T sin_{0};
};

using SO2d = SO2<double>;  ///< of double

/// A rigid motion of the plane. Tangent vectors are (x, y, θ) in metres and radians.
template <class T>
class SE2 {
 public:
  using Scalar = T;                         ///< floating point, pack or dual number
  static constexpr int kDof = 3;            ///< dimension of the tangent space
  using Tangent = Eigen::Matrix<T, 3, 1>;   ///< (x, y, θ)
  using Jacobian = Eigen::Matrix<T, 3, 3>;  ///< of maps between tangents
  using Vector = Eigen::Matrix<T, 2, 1>;    ///< a point of the plane

  SE2() = default;
  /// First the rotation, then the translation.
  SE2(const Vector& translation, const SO2<T>& rotation)
      : translation_(translation), rotation_(rotation) {}
  /// Position in metres and heading.
  SE2(const T& x, const T& y, const BasicAngle<T>& heading)
      : translation_(x, y), rotation_(heading) {}
  template <BareNumber Bare>
  SE2(T, T, Bare) = delete;  // a heading is an Angle: write 0.3_rad or Angle::degrees(17)

  /// No motion.
  [[nodiscard]] static SE2 identity() { return SE2(); }

  /// Of the translation, metres.
  [[nodiscard]] const T& x() const { return translation_[0]; }
  /// Of the translation, metres.
  [[nodiscard]] const T& y() const { return translation_[1]; }
  /// Of the rotation, in (−π, π].
  [[nodiscard]] BasicAngle<T> heading() const { return rotation_.angle(); }
  /// Metres.
  [[nodiscard]] const Vector& translation() const { return translation_; }
  /// Counter-clockwise.
  [[nodiscard]] const SO2<T>& rotation() const { return rotation_; }

  /// The inverse motion.
  [[nodiscard]] SE2 inverse() const {
    const SO2<T> r = rotation_.inverse();
    return SE2(Vector(-(r * translation_)), r);
  }
  /// `o`, then this motion.
  SE2 operator*(const SE2& o) const {
    return SE2(Vector(translation_ + rotation_ * o.translation_), rotation_ * o.rotation_);
  }
  /// Moves a point.
  Vector operator*(const Vector& p) const { return translation_ + rotation_ * p; }

  /// (156) with V(θ) of (158).
  [[nodiscard]] static SE2 exp(const Tangent& tau) {
    const auto [s, c] = v_coefficients(tau[2]);
    return SE2(Vector(s * tau[0] - c * tau[1], c * tau[0] + s * tau[1]),
               SO2<T>(BasicAngle<T>::radians(tau[2])));
  }
  /// (157).
  [[nodiscard]] Tangent log() const {
    const T theta = rotation_.angle().radians();
    const auto [s, c] = v_coefficients(theta);
    const T scale = T(1) / (s * s + c * c);
    const Vector& t = translation_;
    return Tangent(scale * (s * t[0] + c * t[1]), scale * (s * t[1] - c * t[0]), theta);
  }

  /// (159): transforms a tangent vector from the body frame to the origin's.
  [[nodiscard]] Jacobian adjoint() const {
    Jacobian a = Jacobian::Identity();
    a.template topLeftCorner<2, 2>() = rotation_.matrix();
    a(0, 2) = translation_[1];
    a(1, 2) = -translation_[0];
    return a;
  }

  /// (163): exp(τ + δ) ≈ exp(τ) ∘ exp(Jr(τ) δ).
  [[nodiscard]] static Jacobian right_jacobian(const Tangent& tau) {
    const auto [s, c] = v_coefficients(tau[2]);
    const auto [f, g] = q_coefficients(tau[2]);
    return (Jacobian() << s, c, f * tau[0] - g * tau[1],  //
            -c, s, g * tau[0] + f * tau[1],               //
            T(0), T(0), T(1))
        .finished();
  }
  /// The inverse of right_jacobian.
  [[nodiscard]] static Jacobian right_jacobian_inverse(const Tangent& tau) {
    const Jacobian j = right_jacobian(tau);
    const T scale = T(1) / (j(0, 0) * j(0, 0) + j(0, 1) * j(0, 1));
    Jacobian inverse = Jacobian::Identity();
    inverse.template topLeftCorner<2, 2>() = scale * j.template topLeftCorner<2, 2>().transpose();
    inverse.template topRightCorner<2, 1>() =
        -inverse.template topLeftCorner<2, 2>() * j.template topRightCorner<2, 1>();
    return inverse;
  }

  /// x exp τ.
  [[nodiscard]] SE2 plus(const Tangent& tau) const { return *this * exp(tau); }
  /// τ in x exp τ = *this.
  [[nodiscard]] Tangent minus(const SE2& x) const { return (x.inverse() * *this).log(); }

  /// In another scalar.
  template <class U>
  [[nodiscard]] SE2<U> cast() const {
    return SE2<U>(translation_.template cast<U>(), rotation_.template cast<U>());
  }

 private:
  struct Pair {
    T first, second;
  };
  /// sin θ / θ and (1 − cos θ) / θ.
  static Pair v_coefficients(const T& theta) {
    const T square = theta * theta;
    return {stumpff<1>(square), theta * stumpff<2>(square)};
  }
  /// (θ − sin θ) / θ² and (1 − cos θ) / θ².
  static Pair q_coefficients(const T& theta) {
    const T square = theta * theta;
    return {theta * stumpff<3>(square), stumpff<2>(square)};
  }

  Vector translation_ = Vector::Zero();
  SO2<T> rotation_{};
};

using SE2d = SE2<double>;  ///< of double
using SE2f = SE2<float>;   ///< of float

/// The pose at the fraction `u` of the constant-twist path from `a` to `b`.
template <class G>
[[nodiscard]] G interpolate(const G& a, const G& b, double u) {
  using Scalar = typename G::Scalar;
  return a.plus(Scalar(u) * b.minus(a));
}

}  // namespace wayfare
