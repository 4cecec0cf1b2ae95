#pragma once

// The time scales of satellite navigation as clock types, and their conversions. Nanosecond offsets
// between the systems' realisations (such as GGTO) are part of the receiver's clock states, one per
// system.

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include <wayfare/core/time.hpp>

namespace wayfare {

/// UTC as days of 86400 s since 1980-01-06: a leap second and the second after it share a reading.
struct UtcClock {};
/// GLONASS time: UTC + 3 h including leap seconds; since 1980-01-06T00:00 of that scale.
struct GlonassClock {};
/// BeiDou time since 2006-01-01T00:00 UTC; no leap seconds, 14 s behind GPS.
struct BeidouClock {};
/// Galileo system time since 1999-08-22T00:00 of GPS time; no leap seconds, in step with GPS.
struct GalileoClock {};

inline constexpr Duration kGpsWeek = std::chrono::hours(24 * 7);  ///< 604800 s
/// Week 0 of BeiDou and Galileo is this GPS week.
inline constexpr int kBeidouWeekZero = 1356;
inline constexpr int kGalileoWeekZero = 1024;  ///< week 0 of Galileo is this GPS week
inline constexpr Duration kGpsMinusBeidou = std::chrono::seconds(14);  ///< constant

/// Week and time of week, [0, 7 d), as used by receivers and files.
struct WeekTime {
  int week = 0;         ///< not rolled over
  Duration of_week{0};  ///< from its start
};

/// Weeks beyond ±15250 (292 years) give the nearest representable instant.
[[nodiscard]] constexpr Time<GpsClock> gps_time(int week, Duration of_week) {
  constexpr auto kMost = Duration::max() / kGpsWeek;
  if (week > kMost) return Time<GpsClock>() + Duration::max();
  if (week < -kMost) return Time<GpsClock>() + Duration::min();
  return Time<GpsClock>() + week * kGpsWeek + of_week;
}

/// The inverse of gps_time(week, of_week).
[[nodiscard]] constexpr WeekTime week_time(Time<GpsClock> time) {
  const Duration t = time.since_epoch(), rest = t % kGpsWeek;
  const bool before = rest < Duration(0);
  return {static_cast<int>(t / kGpsWeek) - (before ? 1 : 0), before ? rest + kGpsWeek : rest};
}

/// The instant with this time of week nearest to `near`, for messages without a week number.
[[nodiscard]] constexpr Time<GpsClock> nearest_time_of_week(Duration of_week, Time<GpsClock> near) {
  const Time<GpsClock> there = gps_time(week_time(near).week, of_week);
  if (there - near > kGpsWeek / 2) return there - kGpsWeek;
  if (near - there > kGpsWeek / 2) return there + kGpsWeek;
  return there;
}

/// Undoes the roll-over of a week number sent modulo `cycle` (1024 for GPS legacy messages, 4096
/// for Galileo, 8192 for BeiDou and GPS CNAV): the week nearest to that of `near`.
[[nodiscard]] constexpr int unrolled_week(int week, Time<GpsClock> near, int cycle = 1024) {
  const int reference = week_time(near).week;
  const auto difference = std::int64_t{week} - reference;
  const auto ahead = static_cast<int>((difference % cycle + cycle) % cycle);
  return reference + (ahead > cycle / 2 ? ahead - cycle : ahead);
}

/// GPS time of BeiDou time, exact.
[[nodiscard]] constexpr Time<GpsClock> to_gps(Time<BeidouClock> t) {
  return gps_time(kBeidouWeekZero, kGpsMinusBeidou) + t.since_epoch();
}
/// BeiDou time of GPS time, exact.
[[nodiscard]] constexpr Time<BeidouClock> to_beidou(Time<GpsClock> t) {
  return Time<BeidouClock>() + (t - gps_time(kBeidouWeekZero, kGpsMinusBeidou));
}
/// GPS time of Galileo time, exact.
[[nodiscard]] constexpr Time<GpsClock> to_gps(Time<GalileoClock> t) {
  return gps_time(kGalileoWeekZero, t.since_epoch());
}
/// Galileo time of GPS time, exact.
[[nodiscard]] constexpr Time<GalileoClock> to_galileo(Time<GpsClock> t) {
  return Time<GalileoClock>() + (t - gps_time(kGalileoWeekZero, Duration(0)));
}
/// UTC of GLONASS time, exact in leap seconds too.
[[nodiscard]] constexpr Time<UtcClock> to_utc(Time<GlonassClock> t) {
  return Time<UtcClock>() + t.since_epoch() - std::chrono::hours(3);
}
/// GLONASS time of UTC, exact in leap seconds too.
[[nodiscard]] constexpr Time<GlonassClock> to_glonass(Time<UtcClock> t) {
  return Time<GlonassClock>() + t.since_epoch() + std::chrono::hours(3);
}

/// From this instant of UTC on GPS is `gps_minus_utc_s` ahead of it.
struct LeapSecond {
  Time<UtcClock> from;      ///< first instant of UTC
  int gps_minus_utc_s = 0;  ///< from then on
};

/// All leap seconds since 1980 announced by IERS Bulletin C up to number 70 (the last: 2017-01-01).
[[nodiscard]] std::span<const LeapSecond> leap_second_table();

/// GPS − UTC, s, by a table in order of time; zero before its first entry.
[[nodiscard]] int gps_minus_utc_s(Time<UtcClock> t,
                                  std::span<const LeapSecond> table = leap_second_table());

/// GPS time of UTC, by a table in order of time.
[[nodiscard]] Time<GpsClock> to_gps(Time<UtcClock> t,
                                    std::span<const LeapSecond> table = leap_second_table());
/// Within a leap second, the reading of the following second.
[[nodiscard]] Time<UtcClock> to_utc(Time<GpsClock> t,
                                    std::span<const LeapSecond> table = leap_second_table());

/// A calendar reading of any of the scales; `of_minute` may be 60 s and more in a leap second.
struct CivilTime {
  int year = 1980,        ///< AD
      month = 1,          ///< 1 to 12
      day = 6,            ///< from 1
      hour = 0,           ///< 0 to 23
      minute = 0;         ///< 0 to 59
  Duration of_minute{0};  ///< with fractions
};

/// None for a date that does not exist, a time of day out of range, or a year outside 1980-2099.
[[nodiscard]] std::optional<Time<GpsClock>> gps_from_civil(const CivilTime& civil);
/// None as gps_from_civil.
[[nodiscard]] std::optional<Time<UtcClock>> utc_from_civil(const CivilTime& civil);
/// None as gps_from_civil.
[[nodiscard]] std::optional<Time<BeidouClock>> beidou_from_civil(const CivilTime& civil);
/// The inverse of gps_from_civil.
[[nodiscard]] CivilTime civil_from_gps(Time<GpsClock> time);

/// A recording whose common time base is GPS time.
[[nodiscard]] constexpr LogTime log_time(Time<GpsClock> t) { return LogTime() + t.since_epoch(); }
/// The inverse of log_time.
[[nodiscard]] constexpr Time<GpsClock> gps_time(LogTime t) {
  return Time<GpsClock>() + t.since_epoch();
}

}  // namespace wayfare
