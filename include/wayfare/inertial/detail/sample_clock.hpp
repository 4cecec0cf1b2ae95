#pragma once

#include <wayfare/core/time.hpp>

namespace wayfare {

/// Checks the time stamps of one sensor. Readings not after the previous one are late; if only late
/// ones follow, the clock was set back, and the sequence restarts.
class SampleClock {
 public:
  enum class Verdict { first, next, late };

  explicit SampleClock(double patience_s) : patience_(from_seconds(patience_s)) {}

  /// For a reading at `t`; after `next`, step_s() is the time since the previous one.
  Verdict check(LogTime t) {
    if (!started_) return restart(t);
    if (t > last_) {
      step_s_ = to_seconds(t - last_);
      last_ = t;
      late_run_ = false;
      return Verdict::next;
    }
    if (!late_run_ || t <= late_last_) {
      late_run_ = true;
      late_first_ = t;
    }
    late_last_ = t;
    return t - late_first_ > patience_ ? restart(t) : Verdict::late;
  }

  void forget() { started_ = late_run_ = false; }
  [[nodiscard]] bool started() const { return started_; }
  [[nodiscard]] double step_s() const { return step_s_; }
  [[nodiscard]] LogTime last() const { return last_; }

 private:
  Verdict restart(LogTime t) {
    started_ = true;
    late_run_ = false;
    last_ = t;
    step_s_ = 0.0;
    return Verdict::first;
  }

  Duration patience_;
  LogTime last_, late_first_, late_last_;
  double step_s_ = 0.0;
  bool started_ = false, late_run_ = false;
};

}  // namespace wayfare
