#pragma once

// Time is a whole number of nanoseconds on a named clock. Mixing two clocks does not compile.

#include <chrono>
#include <compare>
#include <cstdint>
#include <limits>
#include <type_traits>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/detail/bare_number.hpp>

namespace wayfare {

/// A difference of two times, whole nanoseconds.
using Duration = std::chrono::nanoseconds;

namespace detail {

/// a + b and a − b, at the limit of a Duration where the result is beyond it.
[[nodiscard]] constexpr Duration saturated_sum(Duration a, Duration b) {
  std::int64_t sum = 0;
  if (!__builtin_add_overflow(a.count(), b.count(), &sum)) [[likely]]
    return Duration(sum);
  return b < Duration(0) ? Duration::min() : Duration::max();
}
[[nodiscard]] constexpr Duration saturated_difference(Duration a, Duration b) {
  std::int64_t difference = 0;
  if (!__builtin_sub_overflow(a.count(), b.count(), &difference)) [[likely]]
    return Duration(difference);
  return b < Duration(0) ? Duration::max() : Duration::min();
}

}  // namespace detail

/// The common time base of all measurements of one recording or running system.
struct LogClock {};
/// A sensor's own counter, before conversion to the common time base.
struct DeviceClock {};
/// The computer's monotonic clock.
struct HostClock {};
/// GPS time since 1980-01-06T00:00:00, no leap seconds.
struct GpsClock {};

/// An instant on `Clock`, as nanoseconds since that clock's epoch. Sums and differences beyond the
/// 292 years that these can count are the nearest representable value.
template <class Clock>
class Time {
 public:
  constexpr Time() = default;
  template <BareNumber Bare>
  Time(Bare) = delete;  // an instant has a unit: Time::from_seconds(s) or from_nanoseconds(ns)

  /// Since the clock's epoch.
  [[nodiscard]] static constexpr Time from_nanoseconds(std::int64_t ns) {
    return Time(Duration(ns));
  }
  /// Rounds to the nearest nanosecond (the readers convert text exactly, without a double). Beyond
  /// ±292 years the nearest representable instant; NaN violates the precondition.
  [[nodiscard]] static constexpr Time from_seconds(double s) {
    WAYFARE_EXPECTS(s == s, "an instant is a number of seconds, not NaN");
    using Limits = std::numeric_limits<std::int64_t>;
    const double ns = s * 1e9;
    if (ns >= 0x1p63) return from_nanoseconds(Limits::max());
    if (!(ns >= -0x1p63)) return from_nanoseconds(Limits::min());
    const auto whole = static_cast<std::int64_t>(ns);
    const double rest = ns - static_cast<double>(whole);
    return from_nanoseconds(whole + (rest >= 0.5 ? 1 : 0) - (rest <= -0.5 ? 1 : 0));
  }

  /// Since the clock's epoch.
  [[nodiscard]] constexpr std::int64_t nanoseconds() const { return since_epoch_.count(); }
  /// Since the clock's epoch, rounded to a double.
  [[nodiscard]] constexpr double seconds() const {
    return static_cast<double>(nanoseconds()) * 1e-9;
  }
  /// As a duration.
  [[nodiscard]] constexpr Duration since_epoch() const { return since_epoch_; }

  /// @{
  /// An instant later or earlier, saturated.
  constexpr Time operator+(Duration d) const {
    return Time(detail::saturated_sum(since_epoch_, d));
  }
  constexpr Time operator-(Duration d) const {
    return Time(detail::saturated_difference(since_epoch_, d));
  }
  constexpr Time& operator+=(Duration d) { return *this = *this + d; }
  /// @}

  /// @{
  /// From `other` to this instant, saturated.
  template <class Other>
  constexpr Duration operator-(Time<Other> other) const {
    return detail::saturated_difference(since_epoch_, on_this_clock(other));
  }
  /// @}
  /// @{
  /// Of instants on the same clock.
  template <class Other>
  constexpr std::strong_ordering operator<=>(Time<Other> other) const {
    return nanoseconds() <=> on_this_clock(other).count();
  }
  template <class Other>
  constexpr bool operator==(Time<Other> other) const {
    return since_epoch_ == on_this_clock(other);
  }
  /// @}

 private:
  constexpr explicit Time(Duration since_epoch) : since_epoch_(since_epoch) {}

  template <class Other>
  static constexpr Duration on_this_clock(Time<Other> time) {
    static_assert(std::is_same_v<Clock, Other>,
                  "wayfare: these times are on different clocks; convert one of them first");
    return time.since_epoch();
  }

  Duration since_epoch_{0};
};

using LogTime = Time<LogClock>;  ///< of the recording, the host's clock

/// A duration in seconds.
[[nodiscard]] constexpr double to_seconds(Duration d) {
  return static_cast<double>(d.count()) * 1e-9;
}

/// The nearest whole nanosecond to `s` seconds.
[[nodiscard]] constexpr Duration from_seconds(double s) {
  return LogTime::from_seconds(s).since_epoch();
}

/// The first of the instants grid + k period, k ≥ 0, that is after `time`; the last representable
/// instant where there is none. `period` is positive.
template <class Clock>
[[nodiscard]] constexpr Time<Clock> next_on_grid(Time<Clock> grid, Duration period,
                                                 Time<Clock> time) {
  // Once, or twice where the difference is beyond the range.
  while (grid <= time && grid.since_epoch() < Duration::max())
    grid = grid + (time - grid) / period * period + period;
  return grid;
}

}  // namespace wayfare
