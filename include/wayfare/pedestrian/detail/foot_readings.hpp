#pragma once

// Buffer of the foot tracker: recent readings, their stance statistics and the local minima.

#include <algorithm>
#include <cstddef>
#include <deque>
#include <limits>

#include <wayfare/core/time.hpp>
#include <wayfare/pedestrian/parameters.hpp>
#include <wayfare/pedestrian/stance.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// Queue that releases each reading once it is known whether its statistic is a local minimum.
template <class Statistic>
class FootReadings {
 public:
  using Entry = FootReading;

  FootReadings(const FootParameters& p, const Statistic& statistic)
      : statistic_(statistic),
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
      return entries_.cbegin() + static_cast<std::ptrdiff_t>(i);
    };
    const double statistic = statistic_(StanceWindow(at(first), at(last)));
    e.statistic = statistic >= 0.0 ? statistic : std::numeric_limits<double>::infinity();
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

  Statistic statistic_;
  Duration half_window_, apart_;
  std::deque<Entry> entries_;
  std::size_t evaluated_ = 0, next_ = 0;
  bool closed_ = false;
};

}  // namespace wayfare
