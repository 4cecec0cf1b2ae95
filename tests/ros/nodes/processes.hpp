#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace wayfare::testing {

/// A program run by the test, with its output in a new file; killed if still running at the end.
class Process {
 public:
  Process(const std::vector<std::string>& command, std::string output_file);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  [[nodiscard]] std::string output() const;
  /// Sends it the signal and waits; its exit code, -1 if it had to be killed.
  int end(int signal);
  /// Waits for it to end; its exit code, -1 if it did not within `seconds`.
  int wait(double seconds);

 private:
  pid_t pid_ = -1;
  std::string output_file_;
};

/// Repeats `step` until `done`; false after `seconds`.
bool until(double seconds, const std::function<bool()>& done, const std::function<void()>& step);

/// A free port of the loopback address.
int free_port();

/// A domain of DDS that no other process has of this function, 1 to 100; the same for the rest of
/// the process.
unsigned own_domain();

/// Whether the shell finds a program of this name.
bool is_installed(const std::string& program);

}  // namespace wayfare::testing
