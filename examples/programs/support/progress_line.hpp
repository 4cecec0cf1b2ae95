#pragma once

#include <chrono>
#include <string>

namespace wayfare::examples {

/// One line on standard error that says how far a job is and how long it will still take. Silent
/// where `quiet`, and where the job is over within half a second. Redraws itself on a terminal;
/// elsewhere (a log file) it writes a line now and then.
class ProgressLine {
 public:
  ProgressLine(std::string label, bool quiet);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// `fraction` in [0, 1]; cheap enough to call for every scan.
  void update(double fraction);
  /// Ends the line with the time taken.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;

  void draw(const std::string& text, bool last);

  std::string label_;
  bool quiet_;
  bool terminal_;
  bool shown_ = false;
  bool finished_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_draw_;
};

/// "3:07" from 187 seconds.
[[nodiscard]] std::string minutes_and_seconds(double seconds);

}  // namespace wayfare::examples
