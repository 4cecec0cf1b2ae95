#pragma once

// What the soak programs share: their time, progress with the time remaining, and memory.

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace wayfare::soak {

using Clock = std::chrono::steady_clock;

/// Runs for `--minutes M` (60); other words end the program with its usage.
class Time {
 public:
  Time(int argc, char** argv, const char* about) {
    double minutes = 60.0;
    for (int i = 1; i < argc; ++i) {
      const std::string_view word = argv[i];
      if (word == "--minutes" && i + 1 < argc) {
        minutes = std::atof(argv[++i]);
      } else {
        std::printf("usage: %s [--minutes M]\n%s M is 60 unless given.\n", argv[0], about);
        std::exit(word == "--help" ? 0 : 2);
      }
    }
    if (!(minutes > 0.0 && minutes < 1e5)) {
      std::fprintf(stderr, "--minutes must be positive\n");
      std::exit(2);
    }
    end_ = begin_ + std::chrono::duration_cast<Clock::duration>(
                        std::chrono::duration<double, std::ratio<60>>(minutes));
  }

  [[nodiscard]] bool is_over() const { return Clock::now() >= end_; }
  /// A line on a terminal, at most twice a second.
  void show(const std::string& done) {
    const auto now = Clock::now();
    if (::isatty(1) == 0 || now - shown_ < std::chrono::milliseconds(500)) return;
    shown_ = now;
    std::printf("\r%s, %.0f min left   ", done.c_str(),
                std::chrono::duration<double, std::ratio<60>>(end_ - now).count());
    std::fflush(stdout);
  }

 private:
  Clock::time_point begin_ = Clock::now(), end_, shown_;
};

/// Ends the program at once, its threads with it, with what went wrong.
[[noreturn]] inline void fail(const std::string& what) {
  std::fprintf(stderr, "\nsoak failed: %s\n", what.c_str());
  std::_Exit(1);
}

inline void require(bool good, const std::string& what) {
  if (!good) fail(what);
}

/// Resident memory of this process; 0 under the address sanitizer, which keeps what is freed.
inline double memory_MB() {
#if defined(__SANITIZE_ADDRESS__)
  return 0.0;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
  return 0.0;
#endif
#endif
  std::ifstream in("/proc/self/statm");
  long all = 0, resident = 0;
  in >> all >> resident;
  return static_cast<double>(resident) * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

/// Open files of this process.
inline long open_files() {
  long n = 0;
  for ([[maybe_unused]] const auto& file : std::filesystem::directory_iterator("/proc/self/fd"))
    ++n;
  return n;
}

}  // namespace wayfare::soak
