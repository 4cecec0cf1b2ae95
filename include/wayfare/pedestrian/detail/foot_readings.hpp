#pragma once

// Buffer of the foot tracker: recent readings, their stance statistics and the local minima.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>

#include <Eigen/Core>

#include <wayfare/pedestrian/parameters.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// Stance statistic over readings [begin, end) (Skog et al. 2010 (12) for SHOE, (15) for ARED),
/// with mean about one in stance.
template <class Iterator>
[[nodiscard]] double stance_statistic(Iterator begin, Iterator end, const FootParameters& p) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (auto i = begin; i != end; ++i) mean += i->specific_force_mps2;
  const double norm = mean.norm();
  const Eigen::Vector3d gravity =
      norm > 0.0 ? Eigen::Vector3d(mean * (p.gravity_mps2 / norm)) : mean;
  const double force2 = p.stance_force_sigma * p.stance_force_sigma;
  const double rate2 = p.stance_rate_sigma * p.stance_rate_sigma;
  double sum = 0.0;
  int n = 0;
  for (auto i = begin; i != end; ++i, ++n) {
    sum += i->angular_rate_radps.squaredNorm() / rate2;
    if (p.statistic == StanceStatistic::shoe)
      sum += (i->specific_force_mps2 - gravity).squaredNorm() / force2;
  }
  return n > 0 ? sum / n : 0.0;
}

/// Queue that releases each reading once it is known whether its statistic is a local minimum.
class FootReadings {
 public:
  struct Entry : ImuSample {
    double statistic = 0.0;
    bool stillest = false;
  };

  explicit FootReadings(const FootParameters& p)
      : p_(p),
        half_window_(from_seconds(0.5 * p.stance_window_s)),
        apart_(from_seconds(p.stance_apart_s)) {}

  void add(const ImuSample& sample) {
    entries_.push_back({sample});
    while (evaluated_ < entries_.size() && sample.time - entries_[evaluated_].time >= half_window_)
      evaluate();
  }
  /// No more readings follow.
  void close() {
    while (evaluated_ < entries_.size()) evaluate();
    closed_ = true;
  }
  void clear() {
    entries_.clear();
    evaluated_ = next_ = 0;
    closed_ = false;
  }

  /// Returns the next reading that is due; to be called until false.
  [[nodiscard]] bool next(Entry& entry) {
    if (next_ >= evaluated_) return false;
    if (!closed_ && entries_[evaluated_ - 1].time - entries_[next_].time < apart_) return false;
    entry = entries_[next_];
    entry.stillest = is_stillest();
    ++next_;
    const LogTime oldest = entry.time - std::max(apart_, half_window_);
    while (entries_.front().time < oldest) {
      entries_.pop_front();
      --evaluated_;
      --next_;
    }
    return true;
  }

 private:
  void evaluate() {
    Entry& e = entries_[evaluated_];
    const auto near = [&](const Entry& o) {
      return o.time - e.time <= half_window_ && e.time - o.time <= half_window_;
    };
    auto first = evaluated_, last = evaluated_ + 1;
    while (first > 0 && near(entries_[first - 1])) --first;
    while (last < entries_.size() && near(entries_[last])) ++last;
    const auto at = [&](std::size_t i) {
      return entries_.begin() + static_cast<std::ptrdiff_t>(i);
    };
    e.statistic = stance_statistic(at(first), at(last), p_);
    ++evaluated_;
  }

  [[nodiscard]] bool is_stillest() const {
    const Entry& e = entries_[next_];
    for (std::size_t i = 0; i < evaluated_; ++i) {
      const Entry& o = entries_[i];
      if (o.time - e.time > apart_ || e.time - o.time > apart_ || i == next_) continue;
      if (o.statistic < e.statistic || (o.statistic == e.statistic && i < next_)) return false;
    }
    return true;
  }

  FootParameters p_;
  Duration half_window_, apart_;
  std::deque<Entry> entries_;
  std::size_t evaluated_ = 0, next_ = 0;
  bool closed_ = false;
};

}  // namespace wayfare
