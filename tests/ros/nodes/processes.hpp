#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace wayfare::testing {

/// A program running beside the test, what it prints in a file made anew; killed where it still
/// runs at the end.
class Process {
 public:
  Process(const std::vector<std::string>& command, std::string output_file);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  [[nodiscard]] std::string output() const;
  /// Asks it to end, with the signal, and waits; its exit code, -1 where it had to be killed.
  int end(int signal);
  /// Waits for it to end by itself; its exit code, -1 where it did not within `seconds`.
  int wait(double seconds);

 private:
  pid_t pid_ = -1;
  std::string output_file_;
};

/// Until `done` says so, `step` meanwhile; false after `seconds`.
bool until(double seconds, const std::function<bool()>& done, const std::function<void()>& step);

/// A port of the loopback address nobody uses now.
int free_port();

/// Whether the shell finds a program of this name.
bool is_installed(const std::string& program);

}  // namespace wayfare::testing
