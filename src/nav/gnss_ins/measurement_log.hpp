#pragma once

// Measurements in order of time, some of which may come late.

#include <deque>
#include <iterator>
#include <variant>

#include <wayfare/nav/gnss_ins.hpp>

namespace wayfare::nav {

using Measurement = std::variant<ImuSample, RangeEpoch, GnssFix, WheelSpeed>;

[[nodiscard]] inline LogTime time_of(const Measurement& m) {
  return std::visit([](const auto& x) { return x.time; }, m);
}
[[nodiscard]] inline bool is_imu(const Measurement& m) {
  return std::holds_alternative<ImuSample>(m);
}

struct LogEntry {
  Measurement measurement;
  bool processed = false;  ///< already reported
};
using MeasurementLog = std::deque<LogEntry>;

/// Where `m` belongs: inertial readings before the others of their time.
[[nodiscard]] inline MeasurementLog::iterator place_of(const Measurement& m, MeasurementLog& log) {
  const LogTime t = time_of(m);
  auto at = log.end();
  while (at != log.begin()) {
    const Measurement& before = std::prev(at)->measurement;
    const LogTime tb = time_of(before);
    if (tb < t || (tb == t && (is_imu(before) || !is_imu(m)))) break;
    --at;
  }
  return at;
}

}  // namespace wayfare::nav
