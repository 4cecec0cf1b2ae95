#pragma once

// Access control and rate limits of the monitor's server.

#include <arpa/inet.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace wayfare::examples {

/// Whether it is `localhost`, or an address of the loopback interface: 127.0.0.0/8 in four numbers,
/// or ::1. Names that begin like an address are not.
[[nodiscard]] inline bool is_loopback(const std::string& host) {
  in_addr four{};
  if (::inet_pton(AF_INET, host.c_str(), &four) == 1) return ntohl(four.s_addr) >> 24U == 127;
  return host == "localhost" || host == "::1" || host == "[::1]";
}

/// In small letters, without the port.
[[nodiscard]] inline std::string host_of(std::string host_and_port) {
  const auto colon = host_and_port.rfind(':');
  if (colon != std::string::npos && host_and_port.find(']', colon) == std::string::npos)
    host_and_port.resize(colon);
  for (char& c : host_and_port) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return host_and_port;
}

/// 128 random bits in hexadecimal.
[[nodiscard]] inline std::string random_token() {
  std::random_device random;
  std::string token;
  for (int i = 0; i < 32; ++i) token += "0123456789abcdef"[random() % 16U];
  return token;
}

/// Compares in constant time.
inline bool same(const std::string& a, const std::string& b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^
                  static_cast<unsigned char>(b.empty() ? 0 : b[i % b.size()]);
  return difference == 0;
}

/// `per_s` requests per second, and bursts of twice the number after a pause.
class RateLimit {
 public:
  explicit RateLimit(double per_s) : per_s_(per_s), left_(2.0 * per_s) {}
  [[nodiscard]] bool take() {
    const std::lock_guard lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    const std::chrono::duration<double> since = now - last_;
    last_ = now;
    left_ = std::min(2.0 * per_s_, left_ + per_s_ * since.count());
    if (left_ < 1.0) return false;
    left_ -= 1.0;
    return true;
  }

 private:
  const double per_s_;
  double left_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
  std::mutex mutex_;
};

/// Credentials of a request.
struct Credentials {
  std::string host;           ///< header Host
  std::string origin;         ///< header Origin, of a page that sends the request; may be empty
  std::string authorization;  ///< header Authorization
  std::string token;          ///< parameter token
};

/// Why a request is refused: an HTTP status, 0 if it is accepted.
struct Refusal {
  int status = 0;
  const char* why = "";
};

/// Which requests need the token.
struct AccessOptions {
  std::string token;                ///< empty: none does
  bool reading_needs_token = true;  ///< else only commands do
  std::vector<std::string> hosts;   ///< names of this host besides those of the loopback interface
  double requests_per_s = 200.0;    ///< of clients with the token, and of those accepted without;
                                    ///< a tenth of it for refused ones
};

/// Accepts commands with the token; reading requests with the token or, where it is not needed,
/// those that address this host by name and come from no page of another. Rate limits are separate
/// for clients with the token, accepted ones without and refused ones: none can shut out another.
class Access {
 public:
  explicit Access(AccessOptions options)
      : options_(std::move(options)),
        owners_(options_.requests_per_s),
        guests_(options_.requests_per_s),
        strangers_(0.1 * options_.requests_per_s) {}

  [[nodiscard]] Refusal check(const Credentials& given, bool is_command) {
    const bool known = knows_token(given);
    const bool open = options_.token.empty() || (!options_.reading_needs_token && !is_command);
    // Pages of other sites must not read by DNS rebinding, nor send commands.
    const bool here = (known || is_here(given.host)) &&
                      (given.origin.empty() || given.origin == "http://" + given.host);
    const bool accepted = here && (known || open);
    RateLimit& limit = !accepted ? strangers_ : known ? owners_ : guests_;
    if (!limit.take()) return {429, "too many requests"};
    if (!here && (known || open)) return {403, "this is another host"};
    if (!accepted) return {401, "the token is missing or wrong"};
    return {};
  }

 private:
  [[nodiscard]] bool is_here(const std::string& host_and_port) const {
    const std::string host = host_of(host_and_port);
    return is_loopback(host) || std::ranges::find(options_.hosts, host) != options_.hosts.end();
  }
  [[nodiscard]] bool knows_token(const Credentials& given) const {
    if (options_.token.empty()) return false;
    constexpr std::size_t kBearer = 7;
    if (given.authorization.rfind("Bearer ", 0) == 0 &&
        same(given.authorization.substr(kBearer), options_.token))
      return true;
    return same(given.token, options_.token);
  }

  const AccessOptions options_;
  RateLimit owners_, guests_, strangers_;
};

}  // namespace wayfare::examples
