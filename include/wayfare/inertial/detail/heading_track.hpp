#pragma once

// Recent heading changes from the gyro alone, to use delayed headings.

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/time.hpp>

namespace wayfare {

/// History of sums over the gyro readings. No heap allocation.
class HeadingTrack {
 public:
  /// Since the beginning: heading change without bias correction, rad; its derivative by minus the
  /// bias along each body axis, s; variance gained by noise, rad².
  struct Sum {
    double angle = 0.0;
    Eigen::Vector3d by_bias = Eigen::Vector3d::Zero();
    double variance = 0.0;

    Sum operator+(const Sum& o) const {
      return {angle + o.angle, by_bias + o.by_bias, variance + o.variance};
    }
    Sum operator-(const Sum& o) const {
      return {angle - o.angle, by_bias - o.by_bias, variance - o.variance};
    }
    Sum operator*(double k) const { return {k * angle, k * by_bias, k * variance}; }
    /// Heading change corrected for a bias.
    [[nodiscard]] double rotation(const Eigen::Vector3d& bias) const {
      return angle - by_bias.dot(bias);
    }
  };

  explicit HeadingTrack(double history_s)
      : history_s_(history_s), spacing_s_(history_s / double(kEntries - 3)) {}

  [[nodiscard]] bool on() const { return history_s_ > 0.0; }
  void forget() { count_ = 0; }

  /// Adds one reading's part, valid at `time`; times increase.
  void add(LogTime time, const Sum& part) {
    sum_ = sum_ + part;
    if (count_ < 2 || to_seconds(entry(0).time - entry(1).time) >= spacing_s_) {
      newest_ = (newest_ + 1) % kEntries;
      count_ = std::min(count_ + 1, kEntries);
    }
    entries_[newest_] = {time, sum_};
  }

  [[nodiscard]] const Sum& now() const { return sum_; }
  /// Interpolated between readings and extrapolated briefly beyond the last; none if further in the
  /// future or older than the history.
  [[nodiscard]] std::optional<Sum> at(LogTime time) const {
    if (count_ == 0 || to_seconds(entry(0).time - time) > history_s_) return std::nullopt;
    if (time == entry(0).time) return entry(0).sum;
    if (to_seconds(time - entry(0).time) > kAhead_s) return std::nullopt;
    for (std::size_t age = 1; age < count_; ++age)
      if (entry(age).time <= time || (age == 1 && time > entry(0).time))
        return between(entry(age), entry(age - 1), time);
    return std::nullopt;
  }
  /// Whether `time` is beyond the extrapolation.
  [[nodiscard]] bool in_future(LogTime time) const {
    return count_ == 0 || to_seconds(time - entry(0).time) > kAhead_s;
  }

 private:
  static constexpr std::size_t kEntries = 256;
  static constexpr double kAhead_s = 0.05;
  struct Entry {
    LogTime time;
    Sum sum;
  };

  [[nodiscard]] const Entry& entry(std::size_t age) const {
    return entries_[(newest_ + kEntries - age) % kEntries];
  }
  static Sum between(const Entry& a, const Entry& b, LogTime time) {
    return a.sum + (b.sum - a.sum) * (to_seconds(time - a.time) / to_seconds(b.time - a.time));
  }

  double history_s_, spacing_s_;
  Sum sum_;
  std::array<Entry, kEntries> entries_{};
  std::size_t newest_ = 0, count_ = 0;
};

}  // namespace wayfare
