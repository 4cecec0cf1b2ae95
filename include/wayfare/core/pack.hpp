#pragma once

// SIMD packs: Pack<double, 8> computes on eight lanes at once wherever a template takes a scalar,
// so that one instruction stream runs many filters. Uses the vector extensions of GCC and Clang on
// any instruction set; a pack as wide as a register is fastest. Do not pass packs between
// translation units compiled for different instruction sets.
//
// Code for both scalars and packs branches with select(), any() and all() instead of `if`.

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <type_traits>

#include <Eigen/Core>

namespace wayfare {

/// One boolean per lane.
template <class T, int N>
struct Mask {
  static_assert(N > 0 && std::has_single_bit(static_cast<unsigned>(N)));
  using Int =
      std::conditional_t<sizeof(T) == 8, std::int64_t, std::int32_t>;  ///< as wide as a lane of T
  /// N of them in the compiler's vector extension.
  using Lanes __attribute__((vector_size(sizeof(T) * N))) = Int;

  Lanes v;  ///< all bits set, or none

  Mask() = default;
  /// The same in every lane.
  Mask(bool yes) : v(Lanes{} - static_cast<Int>(yes ? 1 : 0)) {}  // NOLINT(*-explicit*)
  /// From a vector of lanes.
  [[nodiscard]] static Mask from_lanes(const Lanes& lanes) {
    Mask m;
    m.v = lanes;
    return m;
  }

  /// Whether the lane is set.
  [[nodiscard]] bool operator[](int lane) const { return v[lane] != 0; }
  /// Sets one lane.
  void set(int lane, bool yes) { v[lane] = static_cast<Int>(yes ? -1 : 0); }

  /// @{
  /// Lane by lane.
  friend Mask operator&&(const Mask& a, const Mask& b) { return from_lanes(a.v & b.v); }
  friend Mask operator||(const Mask& a, const Mask& b) { return from_lanes(a.v | b.v); }
  friend Mask operator!(const Mask& a) { return from_lanes(~a.v); }
  /// @}
};

/// N floating-point numbers that are computed together, lane by lane.
template <class T, int N>
struct Pack {
  static_assert(std::is_floating_point_v<T>);
  static_assert(N > 0 && std::has_single_bit(static_cast<unsigned>(N)));
  static constexpr int kLanes = N;  ///< number of lanes
  using Lane = T;                   ///< type of a lane
  /// N of them in the compiler's vector extension.
  using Lanes __attribute__((vector_size(sizeof(T) * N))) = T;

  Lanes v;  ///< the lanes

  Pack() = default;
  /// The same value in every lane.
  template <class U>
  requires std::is_arithmetic_v<U> Pack(U x)
      : v(Lanes{} + static_cast<T>(x)) {}  // NOLINT(*-explicit*)
  /// From a vector of lanes.
  [[nodiscard]] static Pack from_lanes(const Lanes& lanes) {
    Pack p;
    p.v = lanes;
    return p;
  }

  /// One lane.
  [[nodiscard]] T operator[](int lane) const { return v[lane]; }
  /// Sets one lane.
  void set(int lane, T x) { v[lane] = x; }

  /// @{
  /// Lane by lane.
  friend Pack operator+(const Pack& a, const Pack& b) { return from_lanes(a.v + b.v); }
  friend Pack operator-(const Pack& a, const Pack& b) { return from_lanes(a.v - b.v); }
  friend Pack operator*(const Pack& a, const Pack& b) { return from_lanes(a.v * b.v); }
  friend Pack operator/(const Pack& a, const Pack& b) { return from_lanes(a.v / b.v); }
  friend Pack operator-(const Pack& a) { return from_lanes(-a.v); }
  friend Pack operator+(const Pack& a) { return a; }
  Pack& operator+=(const Pack& o) { return v += o.v, *this; }
  Pack& operator-=(const Pack& o) { return v -= o.v, *this; }
  Pack& operator*=(const Pack& o) { return v *= o.v, *this; }
  Pack& operator/=(const Pack& o) { return v /= o.v, *this; }
  /// @}

  /// @{
  /// Lane by lane.
  friend Mask<T, N> operator<(const Pack& a, const Pack& b) { return mask(a.v < b.v); }
  friend Mask<T, N> operator<=(const Pack& a, const Pack& b) { return mask(a.v <= b.v); }
  friend Mask<T, N> operator>(const Pack& a, const Pack& b) { return mask(a.v > b.v); }
  friend Mask<T, N> operator>=(const Pack& a, const Pack& b) { return mask(a.v >= b.v); }
  friend Mask<T, N> operator==(const Pack& a, const Pack& b) { return mask(a.v == b.v); }
  friend Mask<T, N> operator!=(const Pack& a, const Pack& b) { return mask(a.v != b.v); }
  /// @}

  /// `f` on every lane.
  template <class F>
  [[nodiscard]] friend Pack each_lane(const Pack& a, F f) {
    Pack r;
    for (int i = 0; i < N; ++i) r.v[i] = f(a.v[i]);
    return r;
  }
  /// @{
  /// Lane by lane.
  friend Pack sqrt(const Pack& a) {
    return each_lane(a, [](T x) { return std::sqrt(x); });
  }
  friend Pack sin(const Pack& a) {
    return each_lane(a, [](T x) { return std::sin(x); });
  }
  friend Pack cos(const Pack& a) {
    return each_lane(a, [](T x) { return std::cos(x); });
  }
  friend Pack tan(const Pack& a) {
    return each_lane(a, [](T x) { return std::tan(x); });
  }
  friend Pack exp(const Pack& a) {
    return each_lane(a, [](T x) { return std::exp(x); });
  }
  friend Pack log(const Pack& a) {
    return each_lane(a, [](T x) { return std::log(x); });
  }
  friend Pack floor(const Pack& a) {
    return each_lane(a, [](T x) { return std::floor(x); });
  }
  /// @}
  /// The angle of (b, a), lane by lane.
  friend Pack atan2(const Pack& a, const Pack& b) {
    Pack r;
    for (int i = 0; i < N; ++i) r.v[i] = std::atan2(a.v[i], b.v[i]);
    return r;
  }
  /// Lane by lane.
  friend Pack abs(const Pack& a) { return select(a < Pack(0), -a, a); }

  /// Lane by lane `yes` where the mask is set, else `no`.
  friend Pack select(const Mask<T, N>& m, const Pack& yes, const Pack& no) {
    using Bits = typename Mask<T, N>::Lanes;
    return from_lanes(__builtin_bit_cast(
        Lanes, (m.v & __builtin_bit_cast(Bits, yes.v)) | (~m.v & __builtin_bit_cast(Bits, no.v))));
  }

 private:
  template <class Comparison>
  static Mask<T, N> mask(const Comparison& c) {
    return Mask<T, N>::from_lanes(__builtin_bit_cast(typename Mask<T, N>::Lanes, c));
  }
};

/// Whether at least one lane is true.
template <class T, int N>
[[nodiscard]] bool any(const Mask<T, N>& m) {
  typename Mask<T, N>::Int bits = 0;
  for (int i = 0; i < N; ++i) bits |= m.v[i];
  return bits != 0;
}
/// Whether every lane is true.
template <class T, int N>
[[nodiscard]] bool all(const Mask<T, N>& m) {
  return !any(!m);
}

/// @{
/// Of a scalar comparison, for code that is generic in the number of lanes.
[[nodiscard]] constexpr bool any(bool m) { return m; }
[[nodiscard]] constexpr bool all(bool m) { return m; }
template <std::floating_point T>
[[nodiscard]] constexpr T select(bool m, std::type_identity_t<T> yes, T no) {
  return m ? yes : no;
}
/// @}

/// The result of comparing two T: bool, or a mask of lanes.
template <class T>
using MaskOf = decltype(std::declval<const T&>() < std::declval<const T&>());

/// The scalar type of one lane; of a scalar, itself.
template <class T>
struct LaneOf {
  using Type = T;                   ///< itself
  static constexpr int kLanes = 1;  ///< one
};
/// Of a pack.
template <class T, int N>
struct LaneOf<Pack<T, N>> {
  using Type = T;                   ///< of a lane
  static constexpr int kLanes = N;  ///< of the pack
};

/// Lane `i` of a pack or a mask; a scalar or bool has one lane.
template <class T>
[[nodiscard]] auto lane(const T& x, [[maybe_unused]] int i) {
  if constexpr (std::is_arithmetic_v<T>)
    return x;
  else
    return x[i];
}
/// Sets lane `i` of a pack or a mask; a scalar or bool has one lane.
template <class T, class U>
void set_lane(T& x, [[maybe_unused]] int i, U value) {
  const auto converted = static_cast<typename LaneOf<T>::Type>(value);
  if constexpr (std::is_arithmetic_v<T>)
    x = converted;
  else
    x.set(i, converted);
}

/// Neither infinite nor NaN, lane by lane.
template <class T>
[[nodiscard]] MaskOf<T> is_finite(const T& x) {
  return x - x == T(0);  // NOLINT(misc-redundant-expression): NaN − NaN and ∞ − ∞ are NaN
}

}  // namespace wayfare

namespace Eigen {
/// Lets packs be elements of Eigen's matrices.
template <class T, int N>
struct NumTraits<wayfare::Pack<T, N>> : GenericNumTraits<wayfare::Pack<T, N>> {
  using Real = wayfare::Pack<T, N>;  ///< has no imaginary part
  enum {
    IsSigned = 1,              ///< with a sign
    RequireInitialization = 0  ///< like T
  };
  /// @{
  /// Of a lane.
  static Real epsilon() { return Real(NumTraits<T>::epsilon()); }
  static Real dummy_precision() { return Real(NumTraits<T>::dummy_precision()); }
  static Real highest() { return Real(NumTraits<T>::highest()); }
  static Real lowest() { return Real(NumTraits<T>::lowest()); }
  static int digits10() { return NumTraits<T>::digits10(); }
  /// @}
};

namespace internal {
/// Arrays of packs are aligned as packs are, which may be more than Eigen's default.
template <class T, int N, int Size>
struct compute_default_alignment<wayfare::Pack<T, N>, Size> {
  enum {
    value = 0  ///< that of the type
  };
};
}  // namespace internal
}  // namespace Eigen
