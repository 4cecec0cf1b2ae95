#pragma once

// What the tests of this folder have in common: numbers that spoil a computation, the life of an
// object (copied, moved from, assigned to itself), and two instances at work in two threads.

#include <array>
#include <cmath>
#include <concepts>
#include <functional>
#include <limits>
#include <thread>
#include <type_traits>
#include <utility>

#include <gtest/gtest.h>

namespace wayfare::tests {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInf = std::numeric_limits<double>::infinity();
inline constexpr double kHuge = 1e300;  ///< its square overflows
inline constexpr double kTiny = 1e-300;

/// Numbers that no measurement has.
inline constexpr std::array<double, 3> kNotFinite = {kNan, kInf, -kInf};
/// And those that are finite, but far from any use.
inline constexpr std::array<double, 4> kExtreme = {kHuge, -kHuge, kTiny,
                                                   std::numeric_limits<double>::denorm_min()};

/// Calls `work(instance)` for 0 and 1 at the same time on two threads, and returns both results:
/// objects that share nothing do not disturb each other, and give the same for the same input.
template <class Work>
[[nodiscard]] auto in_two_threads(const Work& work) {
  using Result = std::invoke_result_t<const Work&, int>;
  std::array<Result, 2> results{};
  {
    std::jthread other([&] { results[1] = work(1); });
    results[0] = work(0);
  }
  return results;
}

/// The life of an object between its uses. `probe(object)` returns what can be observed of it, a
/// value with ==; it may change the object. A copy has the same future as its source and does not
/// share it; a moved object continues the life of its source; assignment to itself changes nothing;
/// a moved-from object can be assigned to and destroyed.
template <class T, class Probe>
void expect_value_semantics(const T& source, const Probe& probe) {
  if constexpr (std::copy_constructible<T>) {
    T first(source);
    const auto expected = probe(first);
    T second(source);
    EXPECT_EQ(probe(second), expected) << "the source changed with its copy, or a copy is different";
    T third(source);
    T moved(std::move(third));
    EXPECT_EQ(probe(moved), expected) << "moved";
    if constexpr (std::is_copy_assignable_v<T>) {
      third = source;
      T& same = third;
      third = same;
      EXPECT_EQ(probe(third), expected) << "assigned to a moved-from object, then to itself";
    }
    if constexpr (std::is_move_assignable_v<T>) {
      T fourth(source);
      first = std::move(fourth);
      EXPECT_EQ(probe(first), expected) << "moved to a used object";
      if constexpr (std::is_copy_assignable_v<T>) {
        fourth = source;
        EXPECT_EQ(probe(fourth), expected) << "assigned to a moved-from object";
      }
    }
  }
}

/// The same for types that can only be moved: `make()` returns equal objects.
template <class Make, class Probe>
void expect_move_semantics(const Make& make, const Probe& probe) {
  auto first = make();
  const auto expected = probe(first);
  auto second = make();
  auto moved(std::move(second));
  EXPECT_EQ(probe(moved), expected) << "moved";
  if constexpr (std::is_move_assignable_v<decltype(make())>) {
    second = make();
    EXPECT_EQ(probe(second), expected) << "assigned to a moved-from object";
    auto third = make();
    first = std::move(third);
    EXPECT_EQ(probe(first), expected) << "moved to a used object";
  }
}

}  // namespace wayfare::tests
