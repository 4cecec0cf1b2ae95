#pragma once

// How long the disk has room.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include <wayfare/core/time.hpp>

namespace wayfare::logger {

/// The rate at which the disk fills, by the recording or by others, over the last ten seconds.
class DiskWatch {
 public:
  /// Bytes of the recording so far and bytes left.
  void add(LogTime now, std::uint64_t written, std::uint64_t free) {
    constexpr Duration kWindow = std::chrono::seconds(10);
    const Sample sample{now, static_cast<double>(written), static_cast<double>(free)};
    if (!samples_.empty() && sample.written < samples_.back().written) samples_.clear();
    samples_.push_back(sample);
    while (now - samples_.front().time > kWindow) samples_.pop_front();
  }

  /// Bytes per second; nothing within the first second.
  [[nodiscard]] std::optional<double> rate() const {
    if (samples_.empty()) return std::nullopt;
    const Sample &first = samples_.front(), &last = samples_.back();
    const double s = to_seconds(last.time - first.time);
    if (!(s >= 1.0)) return std::nullopt;
    return std::max({last.written - first.written, first.free - last.free, 0.0}) / s;
  }
  /// Until the disk is full at that rate; nothing where it does not fill.
  [[nodiscard]] std::optional<double> seconds_left() const {
    const auto per_s = rate();
    if (!per_s || *per_s <= 0.0) return std::nullopt;
    return samples_.back().free / *per_s;
  }

 private:
  struct Sample {
    LogTime time;
    double written, free;
  };
  std::deque<Sample> samples_;
};

}  // namespace wayfare::logger
