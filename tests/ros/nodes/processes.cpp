#include "processes.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>

namespace wayfare::testing {

Process::Process(const std::vector<std::string>& command, std::string output_file)
    : output_file_(std::move(output_file)) {
  std::vector<char*> argv;
  for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ != 0) return;
  const int out = ::open(output_file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND, 0600);
  ::dup2(out, 1);
  ::dup2(out, 2);
  ::execvp(argv[0], argv.data());
  ::_exit(127);
}

Process::~Process() {
  if (pid_ > 0) end(SIGKILL);
}

std::string Process::output() const {
  std::ifstream file(output_file_);
  return {std::istreambuf_iterator<char>(file), {}};
}

int Process::end(int signal) {
  ::kill(pid_, signal);
  const int code = wait(10.0);
  if (code != -1 || pid_ < 0) return code;
  ::kill(pid_, SIGKILL);
  wait(10.0);
  return -1;
}

int Process::wait(double seconds) {
  int code = -1;
  const bool ended = until(
      seconds,
      [&] {
        int status = 0;
        if (::waitpid(pid_, &status, WNOHANG) != pid_) return false;
        code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
        return true;
      },
      [] { std::this_thread::sleep_for(std::chrono::milliseconds(10)); });
  if (ended) pid_ = -1;
  return code;
}

bool until(double seconds, const std::function<bool()>& done, const std::function<void()>& step) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    step();
  }
  return true;
}

int free_port() {
  const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t n = sizeof address;
  const bool bound = ::bind(fd, reinterpret_cast<sockaddr*>(&address), n) == 0 &&
                     ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &n) == 0;
  ::close(fd);
  return bound ? ntohs(address.sin_port) : 0;
}

unsigned own_domain() {
  static const unsigned domain = [] {
    // The last port of the domain before it, which DDS does not use, is the sign that it is taken.
    for (unsigned i = 0; i < 100; ++i) {
      const unsigned candidate = (static_cast<unsigned>(::getpid()) + i) % 100 + 1;
      const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      sockaddr_in address{};
      address.sin_family = AF_INET;
      address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      address.sin_port = htons(static_cast<std::uint16_t>(7399 + 250 * candidate));
      if (::bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return candidate;
      ::close(fd);
    }
    return 101U;
  }();
  return domain;
}

bool is_installed(const std::string& program) {
  return std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
}

}  // namespace wayfare::testing
