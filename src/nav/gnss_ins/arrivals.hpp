#pragma once

// Times at which measurements come.

#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare::nav {

[[nodiscard]] inline Error refused(ErrorCode code, LogTime time, const std::string& why) {
  char text[48];
  std::snprintf(text, sizeof text, "%.3f s: ", time.seconds());
  return {code, text + why};
}

/// Times of accepted measurements of one kind.
class ArrivalTimes {
 public:
  [[nodiscard]] bool contains(LogTime time) const {
    return std::find(times_.begin(), times_.end(), time) != times_.end();
  }
  /// Less than a tenth of a second after the last one.
  [[nodiscard]] bool follows_closely(LogTime time) const {
    if (times_.empty()) return false;
    const double since_s = to_seconds(time - times_.back());
    return since_s > 0.0 && since_s < 0.095;
  }
  void restart(LogTime time) { times_.assign(1, time); }
  /// Those before `oldest` are of no interest any more.
  void add(LogTime time, LogTime oldest) {
    std::erase_if(times_, [oldest](LogTime t) { return t < oldest; });
    times_.push_back(time);
  }

 private:
  std::vector<LogTime> times_;
};

/// Epochs with enough satellites for a position.
class FullEpochs {
 public:
  void add(LogTime time) {
    if (last_) interval_s_ += 0.1 * (std::min(to_seconds(time - *last_), 2.0) - interval_s_);
    last_ = time;
  }
  /// Whether there was one not long before `time`, by the usual interval between them.
  [[nodiscard]] bool are_recent(LogTime time) const {
    return last_ && to_seconds(time - *last_) < std::max(0.3, 1.5 * interval_s_);
  }

 private:
  std::optional<LogTime> last_;
  double interval_s_ = 1.0;
};

/// Mean time between readings.
class ReadingInterval {
 public:
  void add(double gap_s) {
    if (!(gap_s > 0.0) || !(gap_s < 1.0)) return;
    mean_s_ = mean_s_ == 0.0 ? gap_s : 0.95 * mean_s_ + 0.05 * std::min(gap_s, 3.0 * mean_s_);
  }
  [[nodiscard]] bool is_gap(double seconds) const {
    return mean_s_ > 0.0 && seconds > std::max(3.0 * mean_s_, 0.02);
  }

 private:
  double mean_s_ = 0.0;
};

}  // namespace wayfare::nav
