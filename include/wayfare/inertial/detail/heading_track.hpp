#pragma once

// How a heading turned of late by the gyro alone, so that one which is told late can be carried on.

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/time.hpp>

namespace wayfare {

/// Sums over the gyro's readings, kept for a while. No heap.
class HeadingTrack {
 public:
  /// Since the beginning: how far the heading turned by the gyro with no bias taken off, rad; how
  /// much less it were per bias along each of the body's axes, s; the variance gained by noise,
  /// rad².
  struct Sum {
    double turned = 0.0;
    Eigen::Vector3d by_bias = Eigen::Vector3d::Zero();
    double variance = 0.0;

    Sum operator+(const Sum& o) const {
      return {turned + o.turned, by_bias + o.by_bias, variance + o.variance};
    }
    Sum operator-(const Sum& o) const {
      return {turned - o.turned, by_bias - o.by_bias, variance - o.variance};
    }
    Sum operator*(double k) const { return {k * turned, k * by_bias, k * variance}; }
    /// The turn, a bias taken off.
    [[nodiscard]] double turn(const Eigen::Vector3d& bias) const {
      return turned - by_bias.dot(bias);
    }
  };

  explicit HeadingTrack(double history_s)
      : history_s_(history_s), spacing_s_(history_s / double(kEntries - 3)) {}

  [[nodiscard]] bool on() const { return history_s_ > 0.0; }
  void forget() { count_ = 0; }

  /// One reading's part, known at `time`, which comes after the one before.
  void add(LogTime time, const Sum& part) {
    sum_ = sum_ + part;
    if (count_ < 2 || to_seconds(entry(0).time - entry(1).time) >= spacing_s_) {
      newest_ = (newest_ + 1) % kEntries;
      count_ = std::min(count_ + 1, kEntries);
    }
    entries_[newest_] = {time, sum_};
  }

  [[nodiscard]] const Sum& now() const { return sum_; }
  /// Between readings in proportion, and a little beyond the last as before it; none for what is
  /// to come or too long past.
  [[nodiscard]] std::optional<Sum> at(LogTime time) const {
    if (count_ == 0 || to_seconds(entry(0).time - time) > history_s_) return std::nullopt;
    if (time == entry(0).time) return entry(0).sum;
    if (to_seconds(time - entry(0).time) > kAhead_s) return std::nullopt;
    for (std::size_t age = 1; age < count_; ++age)
      if (entry(age).time <= time || (age == 1 && time > entry(0).time))
        return between(entry(age), entry(age - 1), time);
    return std::nullopt;
  }
  /// Whether that is because the time has not come.
  [[nodiscard]] bool to_come(LogTime time) const {
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
