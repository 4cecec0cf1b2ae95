#pragma once

// Dual numbers: a value and its derivatives with respect to N variables. A function template
// evaluated on them gives its Jacobian to rounding, at about N + 1 times the cost. (Forward-mode
// automatic differentiation: Griewank, Walther 2008, "Evaluating derivatives", chapter 3.)

#include <cmath>
#include <compare>

#include <Eigen/Core>

namespace wayfare {

/// x + Σ dᵢ εᵢ with εᵢ εⱼ = 0. Comparisons are those of the values. Where a function has no
/// derivative (square root, hypot and atan2 at zero), the derivatives are infinite or NaN.
template <class T, int N>
struct Dual {
  using Derivatives = Eigen::Matrix<T, N, 1>;  ///< ∂/∂x of N variables

  T value{};                                      ///< x
  Derivatives derivatives = Derivatives::Zero();  ///< dᵢ

  Dual() = default;
  /// A constant: its derivatives are zero.
  Dual(T constant) : value(constant) {}  // NOLINT: a constant is a dual number
  /// A value with its derivatives.
  template <class D>
  Dual(T x, const Eigen::MatrixBase<D>& d) : value(x), derivatives(d) {}
  /// The variable with this index.
  [[nodiscard]] static Dual variable(T x, int index) {
    Dual y(x);
    y.derivatives[index] = T(1);
    return y;
  }
  /// Derivative i is `slope(i)`. (One loop for all: each expression of matrices is a type of its
  /// own, which takes its time to compile.)
  template <class F>
  [[nodiscard]] static Dual each(T value, const F& slope) {
    Derivatives d;
    for (int i = 0; i < N; ++i) d[i] = slope(i);
    return {value, d};
  }

  /// @{
  /// Arithmetic with the rules of derivatives.
  Dual& operator+=(const Dual& o) { return *this = *this + o; }
  Dual& operator-=(const Dual& o) { return *this = *this - o; }
  Dual& operator*=(const Dual& o) { return *this = *this * o; }
  Dual& operator/=(const Dual& o) { return *this = *this / o; }
  /// @}

  /// @{
  /// Arithmetic with the rules of derivatives.
  friend Dual operator+(const Dual& a) { return a; }
  friend Dual operator-(const Dual& a) { return chain(a, -a.value, T(-1)); }
  friend Dual operator+(const Dual& a, const Dual& b) {
    return each(a.value + b.value, [&](int i) { return a.derivatives[i] + b.derivatives[i]; });
  }
  friend Dual operator-(const Dual& a, const Dual& b) {
    return each(a.value - b.value, [&](int i) { return a.derivatives[i] - b.derivatives[i]; });
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return each(a.value * b.value,
                [&](int i) { return a.value * b.derivatives[i] + b.value * a.derivatives[i]; });
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const T inverse = T(1) / b.value, ratio = a.value * inverse;
    return each(ratio,
                [&](int i) { return inverse * (a.derivatives[i] - ratio * b.derivatives[i]); });
  }
  /// @}
  /// @{
  /// Of the values alone.
  friend constexpr bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
  friend constexpr auto operator<=>(const Dual& a, const Dual& b) { return a.value <=> b.value; }
  /// @}

  /// f(a) with derivative `slope` there.
  friend Dual chain(const Dual& a, T f, T slope) {
    return each(f, [&](int i) { return slope * a.derivatives[i]; });
  }

  /// @{
  /// With its derivative.
  friend Dual sqrt(const Dual& a) {
    const T root = std::sqrt(a.value);
    return chain(a, root, T(0.5) / root);
  }
  friend Dual exp(const Dual& a) {
    const T f = std::exp(a.value);
    return chain(a, f, f);
  }
  friend Dual log(const Dual& a) { return chain(a, std::log(a.value), T(1) / a.value); }
  friend Dual sin(const Dual& a) { return chain(a, std::sin(a.value), std::cos(a.value)); }
  friend Dual cos(const Dual& a) { return chain(a, std::cos(a.value), -std::sin(a.value)); }
  friend Dual tan(const Dual& a) {
    const T f = std::tan(a.value);
    return chain(a, f, T(1) + f * f);
  }
  friend Dual asin(const Dual& a) {
    return chain(a, std::asin(a.value), T(1) / std::sqrt(T(1) - a.value * a.value));
  }
  friend Dual acos(const Dual& a) {
    return chain(a, std::acos(a.value), T(-1) / std::sqrt(T(1) - a.value * a.value));
  }
  friend Dual atan(const Dual& a) {
    return chain(a, std::atan(a.value), T(1) / (T(1) + a.value * a.value));
  }
  /// @}
  /// The angle of (x, y).
  friend Dual atan2(const Dual& y, const Dual& x) {
    const T squares = x.value * x.value + y.value * y.value;
    return each(std::atan2(y.value, x.value), [&](int i) {
      return (x.value * y.derivatives[i] - y.value * x.derivatives[i]) / squares;
    });
  }
  /// Length of (x, y).
  friend Dual hypot(const Dual& x, const Dual& y) {
    const T length = std::hypot(x.value, y.value);
    return each(length, [&](int i) {
      return (x.value * x.derivatives[i] + y.value * y.derivatives[i]) / length;
    });
  }
  /// a to a constant power.
  friend Dual pow(const Dual& a, T exponent) {
    const T slope = exponent == T(0) ? T(0) : exponent * std::pow(a.value, exponent - T(1));
    return chain(a, std::pow(a.value, exponent), slope);
  }
  /// The slope at zero is that of the right side.
  friend Dual abs(const Dual& a) { return a.value < T(0) ? -a : a; }
  /// Derivatives are zero.
  friend Dual floor(const Dual& a) { return Dual(std::floor(a.value)); }
  /// Whether value and derivatives are finite.
  friend bool isfinite(const Dual& a) {
    return std::isfinite(a.value) && a.derivatives.allFinite();
  }
};

}  // namespace wayfare

namespace Eigen {

/// Lets dual numbers be elements of Eigen's matrices.
template <class T, int N>
struct NumTraits<wayfare::Dual<T, N>> : NumTraits<T> {
  using Real = wayfare::Dual<T, N>;  ///< has no imaginary part
  using NonInteger = Real;           ///< of quotients
  using Nested = Real;               ///< in expressions
  using Literal = Real;              ///< of literals
  enum {
    IsComplex = 0,              ///< a real number
    IsInteger = 0,              ///< not an integer
    IsSigned = 1,               ///< with a sign
    RequireInitialization = 1,  ///< constructed
    ReadCost = 1,               ///< as T
    AddCost = N + 1,            ///< of all parts
    MulCost = 3 * N             ///< of all parts
  };
};

/// Dual numbers with constants.
template <class T, int N, class BinaryOp>
struct ScalarBinaryOpTraits<wayfare::Dual<T, N>, T, BinaryOp> {
  using ReturnType = wayfare::Dual<T, N>;  ///< dual
};
/// Constants with dual numbers.
template <class T, int N, class BinaryOp>
struct ScalarBinaryOpTraits<T, wayfare::Dual<T, N>, BinaryOp> {
  using ReturnType = wayfare::Dual<T, N>;  ///< dual
};

}  // namespace Eigen
