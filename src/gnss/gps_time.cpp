#include <wayfare/gnss/gps_time.hpp>

#include <array>

namespace wayfare {
namespace {

using std::chrono::days;
using std::chrono::sys_days;

constexpr sys_days date(int year, unsigned month, unsigned day) {
  return std::chrono::year(year) / std::chrono::month(month) / std::chrono::day(day);
}

constexpr sys_days kGpsEpoch = date(1980, 1, 6);
constexpr sys_days kBeidouEpoch = date(2006, 1, 1);

constexpr LeapSecond leap(int year, unsigned month, int gps_minus_utc) {
  return {Time<UtcClock>() + Duration(date(year, month, 1) - kGpsEpoch), gps_minus_utc};
}

constexpr std::array kLeapSeconds = {
    leap(1981, 7, 1),  leap(1982, 7, 2),  leap(1983, 7, 3),  leap(1985, 7, 4),  leap(1988, 1, 5),
    leap(1990, 1, 6),  leap(1991, 1, 7),  leap(1992, 7, 8),  leap(1993, 7, 9),  leap(1994, 7, 10),
    leap(1996, 1, 11), leap(1997, 7, 12), leap(1999, 1, 13), leap(2006, 1, 14), leap(2009, 1, 15),
    leap(2012, 7, 16), leap(2015, 7, 17), leap(2017, 1, 18)};

template <class Clock>
std::optional<Time<Clock>> from_civil(sys_days epoch, const CivilTime& c) {
  const auto in = [](int value, int low, int high) { return value >= low && value <= high; };
  if (!in(c.year, 1980, 2099) || !in(c.month, 1, 12) || !in(c.day, 1, 31)) return std::nullopt;
  if (!in(c.hour, 0, 23) || !in(c.minute, 0, 59)) return std::nullopt;
  if (c.of_minute < Duration(0) || c.of_minute >= std::chrono::seconds(61)) return std::nullopt;
  const std::chrono::year_month_day ymd = std::chrono::year(c.year) /
                                          std::chrono::month(static_cast<unsigned>(c.month)) /
                                          std::chrono::day(static_cast<unsigned>(c.day));
  if (!ymd.ok()) return std::nullopt;
  return Time<Clock>() + (Duration(sys_days(ymd) - epoch) + std::chrono::hours(c.hour) +
                          std::chrono::minutes(c.minute) + c.of_minute);
}

}  // namespace

std::span<const LeapSecond> leap_second_table() { return kLeapSeconds; }

int gps_minus_utc_s(Time<UtcClock> t, std::span<const LeapSecond> table) {
  int leaps = 0;
  for (const LeapSecond& entry : table)
    if (t >= entry.from) leaps = entry.gps_minus_utc_s;
  return leaps;
}

Time<GpsClock> to_gps(Time<UtcClock> t, std::span<const LeapSecond> table) {
  return Time<GpsClock>() + t.since_epoch() + std::chrono::seconds(gps_minus_utc_s(t, table));
}

Time<UtcClock> to_utc(Time<GpsClock> t, std::span<const LeapSecond> table) {
  int leaps = 0;
  for (const LeapSecond& entry : table) {
    // The leap second ends at the new difference.
    const Duration starts = (entry.from + std::chrono::seconds(leaps)).since_epoch();
    if (t.since_epoch() >= starts) leaps = entry.gps_minus_utc_s;
  }
  const Duration utc = (t - std::chrono::seconds(leaps)).since_epoch();
  for (const LeapSecond& entry : table) {
    const bool within = entry.gps_minus_utc_s == leaps && utc < entry.from.since_epoch();
    if (within) return Time<UtcClock>() + (utc + std::chrono::seconds(1));
  }
  return Time<UtcClock>() + utc;
}

std::optional<Time<GpsClock>> gps_from_civil(const CivilTime& civil) {
  return from_civil<GpsClock>(kGpsEpoch, civil);
}
std::optional<Time<UtcClock>> utc_from_civil(const CivilTime& civil) {
  return from_civil<UtcClock>(kGpsEpoch, civil);
}
std::optional<Time<BeidouClock>> beidou_from_civil(const CivilTime& civil) {
  return from_civil<BeidouClock>(kBeidouEpoch, civil);
}

CivilTime civil_from_gps(Time<GpsClock> time) {
  const auto day = std::chrono::floor<days>(time.since_epoch());
  const std::chrono::year_month_day ymd(kGpsEpoch + day);
  // Not the difference: the first day of all begins before the first instant.
  Duration of_day = time.since_epoch() % days(1);
  if (of_day < Duration(0)) of_day += days(1);
  const auto hours = std::chrono::floor<std::chrono::hours>(of_day);
  const auto minutes = std::chrono::floor<std::chrono::minutes>(of_day - hours);
  return {static_cast<int>(ymd.year()),
          static_cast<int>(static_cast<unsigned>(ymd.month())),
          static_cast<int>(static_cast<unsigned>(ymd.day())),
          static_cast<int>(hours.count()),
          static_cast<int>(minutes.count()),
          of_day - hours - minutes};
}

}  // namespace wayfare
