#include "progress_line.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace wayfare::examples {
namespace {

constexpr auto kQuietStart = std::chrono::milliseconds(500);

double seconds(std::chrono::steady_clock::duration d) {
  return std::chrono::duration<double>(d).count();
}

}  // namespace

ProgressLine::ProgressLine(std::string label, bool quiet)
    : label_(std::move(label)),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      next_draw_(start_ + kQuietStart) {}

ProgressLine::~ProgressLine() {
  if (shown_ && !finished_ && terminal_) std::fputc('\n', stderr);
}

void ProgressLine::update(double fraction) {
  const auto now = Clock::now();
  if (quiet_ || finished_ || now < next_draw_) return;
  next_draw_ = now + (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(5000));
  const double done = std::clamp(fraction, 0.0, 1.0);
  char numbers[64];
  if (done > 0.0) {
    const double left_s = seconds(now - start_) * (1.0 - done) / done;
    std::snprintf(numbers, sizeof numbers, " %3.0f %%, %s left", 100.0 * done,
                  minutes_and_seconds(left_s).c_str());
  } else {
    std::snprintf(numbers, sizeof numbers, " ...");
  }
  draw(label_ + numbers, false);
}

void ProgressLine::finish() {
  if (finished_) return;
  finished_ = true;
  if (quiet_ || (!shown_ && Clock::now() - start_ < kQuietStart)) return;
  char took[32];
  std::snprintf(took, sizeof took, " done in %.1f s", seconds(Clock::now() - start_));
  draw(label_ + took, true);
}

void ProgressLine::draw(const std::string& text, bool last) {
  shown_ = true;
  std::fprintf(stderr, terminal_ ? "\r\x1b[K%s" : "%s", text.c_str());
  if (last || !terminal_) std::fputc('\n', stderr);
  std::fflush(stderr);
}

std::string minutes_and_seconds(double seconds) {
  const long whole = std::lround(std::clamp(seconds, 0.0, 1e7));
  char text[32];
  std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
  return text;
}

}  // namespace wayfare::examples
