#pragma once

#include <chrono>
#include <string>

namespace wayfare::examples {

/// A line on standard error with the share of a job that is done and the time remaining. Silent if
/// `quiet`, and for jobs of less than half a second. Redrawn on a terminal; elsewhere (a log file)
/// a new line every five seconds.
class ProgressLine {
 public:
  ProgressLine(std::string label, bool quiet);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// `fraction` in [0, 1]; cheap enough for every scan.
  void update(double fraction);
  /// For progress callbacks, by std::ref: updates, and never asks to stop.
  bool operator()(double fraction) {
    update(fraction);
    return true;
  }
  /// Ends the line with the time taken, which is returned, in seconds.
  double finish();

 private:
  using Clock = std::chrono::steady_clock;

  void draw(const std::string& text, bool last);
  [[nodiscard]] double elapsed_s() const;

  std::string label_;
  bool quiet_;
  bool terminal_;
  bool shown_ = false;
  bool finished_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_draw_;
};

}  // namespace wayfare::examples
