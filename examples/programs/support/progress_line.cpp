#include "progress_line.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace wayfare::examples {
namespace {

constexpr auto kQuietStart = std::chrono::milliseconds(500);

}  // namespace

ProgressLine::ProgressLine(std::string label, bool quiet)
    : label_(std::move(label)),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      next_draw_(start_ + kQuietStart) {}

ProgressLine::~ProgressLine() {
  if (shown_ && !finished_ && terminal_) std::fputc('\n', stderr);
}

double ProgressLine::elapsed_s() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

void ProgressLine::update(double fraction) {
  const auto now = Clock::now();
  if (quiet_ || finished_ || now < next_draw_) return;
  next_draw_ = now + (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(5000));
  const double done = std::clamp(fraction, 0.0, 1.0);
  char numbers[64] = " ...";
  if (done > 0.0) {
    const double left_s = elapsed_s() * (1.0 - done) / done;
    const long whole = std::lround(std::clamp(left_s, 0.0, 1e7));
    std::snprintf(numbers, sizeof numbers, " %3.0f %%, %ld:%02ld left", 100.0 * done, whole / 60,
                  whole % 60);
  }
  draw(label_ + numbers, false);
}

double ProgressLine::finish() {
  const double took_s = elapsed_s();
  if (std::exchange(finished_, true)) return took_s;
  if (quiet_ || (!shown_ && Clock::now() - start_ < kQuietStart)) return took_s;
  char took[32];
  std::snprintf(took, sizeof took, " done in %.1f s", took_s);
  draw(label_ + took, true);
  return took_s;
}

void ProgressLine::draw(const std::string& text, bool last) {
  shown_ = true;
  std::fprintf(stderr, terminal_ ? "\r\x1b[K%s" : "%s", text.c_str());
  if (last || !terminal_) std::fputc('\n', stderr);
  std::fflush(stderr);
}

}  // namespace wayfare::examples
