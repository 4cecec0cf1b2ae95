#pragma once

// The clock of all stamps, and when the computer's clock was set.

#include <chrono>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>

#include <wayfare/core/time.hpp>
#include <wayfare/logger/clock_readings.hpp>

namespace wayfare::logger {

inline constexpr std::string_view kClockTopic = "/logger/clock";

/// UTC by the computer's clock.
using WallClock = std::function<LogTime()>;

/// The monotonic clock, which is set to the computer's once.
class LoggerClock {
 public:
  /// Without a `wall`, the system's.
  explicit LoggerClock(WallClock wall) : wall_(wall ? std::move(wall) : WallClock(system_time)) {
    offset_ = read().offset();
  }

  [[nodiscard]] LogTime now() const {
    return LogTime() + (std::chrono::steady_clock::now().time_since_epoch() + offset_);
  }

  /// Both clocks, read within a tenth of a millisecond of each other, or the closest of ten pairs.
  [[nodiscard]] ClockReading read() const {
    constexpr Duration kClose = std::chrono::microseconds(100);
    ClockReading best;
    Duration least = Duration::max();
    for (int i = 0; i < 10 && least > kClose; ++i) {
      const LogTime before = now();
      const LogTime wall = wall_();
      const Duration taken = now() - before;
      if (taken < least) best = {before + taken / 2, wall}, least = taken;
    }
    return best;
  }

 private:
  static LogTime system_time() {
    return LogTime() + Duration(std::chrono::system_clock::now().time_since_epoch());
  }

  WallClock wall_;
  Duration offset_{0};  ///< UTC minus the monotonic clock
};

/// When the computer's clock was set. Between, both clocks advance at the same, adjusted rate.
class ClockWatch {
 public:
  explicit ClockWatch(const LoggerClock& clock) : clock_(clock) {}

  /// A reading, if the clock was set by more than a reading's uncertainty since the last one.
  [[nodiscard]] std::optional<ClockReading> correction() {
    if (!differs(clock_.read())) return std::nullopt;
    const ClockReading again = clock_.read();  // the first pair may have been interrupted
    if (!differs(again)) return std::nullopt;
    last_ = again.offset();
    return again;
  }

 private:
  [[nodiscard]] bool differs(const ClockReading& reading) const {
    constexpr Duration kLeast = std::chrono::milliseconds(1);
    return std::chrono::abs(reading.offset() - last_) >= kLeast;
  }

  const LoggerClock& clock_;
  Duration last_{0};
};

}  // namespace wayfare::logger
