#pragma once

#include <cmath>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/manifold.hpp>

namespace wayfare {

/// A rotation of the plane, counter-clockwise positive, stored as a unit complex number.
template <class T>
class SO2 {
 public:
  using Scalar = T;
  static constexpr int kDof = 1;
  using Tangent = Eigen::Matrix<T, 1, 1>;
  using Jacobian = Eigen::Matrix<T, 1, 1>;
  using Vector = Eigen::Matrix<T, 2, 1>;

  SO2() = default;
  explicit SO2(const BasicAngle<T>& angle) {
    using std::cos, std::sin;
    cos_ = cos(angle.radians());
    sin_ = sin(angle.radians());
  }
  template <BareNumber Bare>
  explicit SO2(Bare) = delete;  // a heading is an Angle: write 0.3_rad or Angle::degrees(17)

  [[nodiscard]] static SO2 identity() { return SO2(); }
  [[nodiscard]] static SO2 exp(const Tangent& tau) { return SO2(BasicAngle<T>::radians(tau[0])); }
  [[nodiscard]] Tangent log() const { return Tangent(angle().radians()); }

  [[nodiscard]] BasicAngle<T> angle() const {
    using std::atan2;
    return BasicAngle<T>::radians(atan2(sin_, cos_));
  }
  [[nodiscard]] const T& cos() const { return cos_; }
  [[nodiscard]] const T& sin() const { return sin_; }
  [[nodiscard]] Eigen::Matrix<T, 2, 2> matrix() const {
    return (Eigen::Matrix<T, 2, 2>() << cos_, -sin_, sin_, cos_).finished();
  }

  [[nodiscard]] SO2 inverse() const { return SO2(cos_, -sin_); }
  SO2 operator*(const SO2& o) const {
    // One Newton step towards unit norm keeps long products on the circle.
    const T c = cos_ * o.cos_ - sin_ * o.sin_;
    const T s = sin_ * o.cos_ + cos_ * o.sin_;
    const T scale = T(1.5) - T(0.5) * (c * c + s * s);
    return SO2(c * scale, s * scale);
  }
  Vector operator*(const Vector& v) const {
    return Vector(cos_ * v.x() - sin_ * v.y(), sin_ * v.x() + cos_ * v.y());
  }

  [[nodiscard]] Jacobian adjoint() const { return Jacobian::Ones(); }
  [[nodiscard]] static Jacobian right_jacobian(const Tangent&) { return Jacobian::Ones(); }
  [[nodiscard]] static Jacobian right_jacobian_inverse(const Tangent&) { return Jacobian::Ones(); }

  [[nodiscard]] SO2 plus(const Tangent& tau) const { return *this * exp(tau); }
  [[nodiscard]] Tangent minus(const SO2& x) const { return (x.inverse() * *this).log(); }

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

using SO2d = SO2<double>;

}  // namespace wayfare
