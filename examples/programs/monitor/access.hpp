#pragma once

// Access control and rate limits of the monitor's server.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <random>
#include <string>
#include <utility>

namespace wayfare::examples {

[[nodiscard]] inline bool is_loopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host == "[::1]" || host.rfind("127.", 0) == 0;
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
  std::string authorization;  ///< header Authorization
  std::string token;          ///< parameter token
};

/// Why a request is refused: an HTTP status, 0 if it is accepted.
struct Refusal {
  int status = 0;
  const char* why = "";
};

/// Accepts requests with the token or, without a token, those addressed to this host by name;
/// within rate limits, which are separate for accepted and refused clients.
class Access {
 public:
  Access(std::string token, std::string host, double requests_per_s)
      : token_(std::move(token)),
        host_(std::move(host)),
        guests_(requests_per_s),
        strangers_(0.1 * requests_per_s) {}

  [[nodiscard]] Refusal judge(const Credentials& given) {
    const bool here = names_this_host(given.host), known = knows_token(given);
    if (!(here && known ? guests_ : strangers_).take()) return {429, "too many requests"};
    if (!here) return {403, "this is another host"};
    if (!known) return {401, "the token is missing or wrong"};
    return {};
  }

 private:
  /// Without a token, pages of other sites must not reach this server by DNS rebinding.
  [[nodiscard]] bool names_this_host(std::string host) const {
    if (!token_.empty()) return true;
    const auto colon = host.rfind(':');
    if (colon != host.npos && host.find(']', colon) == host.npos) host.resize(colon);
    return is_loopback(host) || host == host_;
  }

  [[nodiscard]] bool knows_token(const Credentials& given) const {
    if (token_.empty()) return true;
    constexpr std::size_t kBearer = 7;
    if (given.authorization.rfind("Bearer ", 0) == 0 &&
        same(given.authorization.substr(kBearer), token_))
      return true;
    return same(given.token, token_);
  }

  const std::string token_, host_;
  RateLimit guests_, strangers_;
};

}  // namespace wayfare::examples
