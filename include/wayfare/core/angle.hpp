#pragma once

// Angles are their own type at the border of the API: radians inside, degrees only by name.

#include <cmath>
#include <compare>
#include <numbers>
#include <type_traits>

#include <wayfare/core/detail/bare_number.hpp>

namespace wayfare {

/// The representative of `radians` in (-pi, pi], pi being the nearest T. NaN where it is not
/// finite.
template <class T>
[[nodiscard]] T wrap_to_pi(const T& radians) {
  using std::floor;
  const T pi = T(std::numbers::pi);
  if (radians > -pi && radians <= pi) return radians;
  T wrapped{};
  if constexpr (std::is_floating_point_v<T>) {
    wrapped = std::remainder(radians, 2 * pi);  // exact, where a floor loses the last bits
  } else {
    wrapped = radians - T(2) * pi * floor((radians + pi) / (T(2) * pi));
  }
  return wrapped <= -pi ? pi : wrapped;
}

/// An angle of either sign, not wrapped. Sums, differences and multiples are those of the radians.
template <class T>
class BasicAngle {
 public:
  constexpr BasicAngle() = default;
  template <BareNumber Bare>
  BasicAngle(Bare) = delete;  // an angle has a unit: Angle::radians(x) or Angle::degrees(x)

  /// From radians.
  [[nodiscard]] static constexpr BasicAngle radians(const T& value) { return BasicAngle(value); }
  /// From degrees.
  [[nodiscard]] static constexpr BasicAngle degrees(const T& value) {
    return BasicAngle(value * T(std::numbers::pi / 180.0));
  }

  /// In radians.
  [[nodiscard]] constexpr const T& radians() const { return radians_; }
  /// In degrees.
  [[nodiscard]] constexpr T degrees() const { return radians_ * T(180.0 / std::numbers::pi); }

  /// The same direction with a value in (-pi, pi].
  [[nodiscard]] BasicAngle wrapped() const { return BasicAngle(wrap_to_pi(radians_)); }

  /// @{
  /// Of the radians, not wrapped.
  constexpr BasicAngle operator-() const { return BasicAngle(-radians_); }
  constexpr BasicAngle operator+(const BasicAngle& o) const {
    return BasicAngle(radians_ + o.radians_);
  }
  constexpr BasicAngle operator-(const BasicAngle& o) const {
    return BasicAngle(radians_ - o.radians_);
  }
  constexpr BasicAngle operator*(const T& k) const { return BasicAngle(radians_ * k); }
  constexpr BasicAngle operator/(const T& k) const { return BasicAngle(radians_ / k); }
  constexpr T operator/(const BasicAngle& o) const { return radians_ / o.radians_; }
  friend constexpr BasicAngle operator*(const T& k, const BasicAngle& a) { return a * k; }
  constexpr BasicAngle& operator+=(const BasicAngle& o) { return *this = *this + o; }
  constexpr BasicAngle& operator-=(const BasicAngle& o) { return *this = *this - o; }
  constexpr auto operator<=>(const BasicAngle&) const = default;
  /// @}

 private:
  constexpr explicit BasicAngle(const T& value) : radians_(value) {}

  T radians_{};
};

/// Of scalars; of dual numbers and packs: BasicAngle<T>.
using Angle = BasicAngle<double>;

inline namespace literals {
/// @{
/// Literals of angles, after `using namespace wayfare::literals`: `90_deg`, `1.57_rad`.
constexpr Angle operator""_rad(long double v) { return Angle::radians(static_cast<double>(v)); }
constexpr Angle operator""_rad(unsigned long long v) {
  return Angle::radians(static_cast<double>(v));
}
constexpr Angle operator""_deg(long double v) { return Angle::degrees(static_cast<double>(v)); }
constexpr Angle operator""_deg(unsigned long long v) {
  return Angle::degrees(static_cast<double>(v));
}
/// @}
}  // namespace literals

}  // namespace wayfare
