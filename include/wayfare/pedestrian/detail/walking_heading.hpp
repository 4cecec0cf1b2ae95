#pragma once

// Recent headings of an axis of the unit: steps are detected with a delay.

#include <algorithm>
#include <array>
#include <cstddef>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

/// Moving average, since heads and hands turn to and fro.
class WalkingHeading {
 public:
  struct Entry {
    LogTime time;
    double radians = 0.0;  ///< not wrapped, averaged
    double variance = 0.0;
  };

  explicit WalkingHeading(double average_s) : average_s_(average_s) {}

  /// Returns the time since the previous reading, s; zero for the first.
  double add(LogTime time, double radians, double variance) {
    const double dt = started_ ? to_seconds(time - last_) : 0.0;
    if (!started_ || dt < 0.0 || dt > 1.0) {
      unwrapped_ = average_ = radians;
      count_ = 0;
    } else {
      unwrapped_ += wrap_to_pi(radians - unwrapped_);
      average_ += std::min(1.0, 2.0 * dt / average_s_) * (unwrapped_ - average_);
    }
    started_ = true;
    last_ = time;
    if (count_ == 0 || to_seconds(time - entry(0).time) >= kSpacing_s) store(time, variance);
    return dt;
  }

  /// Rotates the stored headings by a correction.
  void rotate(double radians) {
    unwrapped_ += radians;
    average_ += radians;
    for (Entry& e : entries_) e.radians += radians;
  }

  /// Latest heading, not averaged.
  [[nodiscard]] double now() const { return unwrapped_; }
  /// The latest entry not after `time`, or the oldest; null before the first.
  [[nodiscard]] const Entry* at(LogTime time) const {
    for (std::size_t age = 0; age < count_; ++age)
      if (entry(age).time <= time) return &entry(age);
    return count_ > 0 ? &entry(count_ - 1) : nullptr;
  }

 private:
  static constexpr std::size_t kEntries = 1024;
  static constexpr double kSpacing_s = 0.02;

  void store(LogTime time, double variance) {
    newest_ = (newest_ + 1) % kEntries;
    entries_[newest_] = {time, average_, variance};
    count_ = std::min(count_ + 1, kEntries);
  }
  [[nodiscard]] const Entry& entry(std::size_t age) const {
    return entries_[(newest_ + kEntries - age) % kEntries];
  }

  double average_s_;
  std::array<Entry, kEntries> entries_;
  std::size_t newest_ = 0, count_ = 0;
  LogTime last_;
  double unwrapped_ = 0.0, average_ = 0.0;
  bool started_ = false;
};

}  // namespace wayfare
