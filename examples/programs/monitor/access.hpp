#pragma once

// Access control and rate limits of the monitor's server.

#include <chrono>
#include <mutex>
#include <string>

namespace wayfare::examples {

[[nodiscard]] bool is_loopback(const std::string& host);
/// 128 random bits in hexadecimal.
[[nodiscard]] std::string random_token();

/// `per_s` requests per second, and bursts of twice the number after a pause.
class RateLimit {
 public:
  explicit RateLimit(double per_s) : per_s_(per_s), left_(2.0 * per_s) {}
  [[nodiscard]] bool take();

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

  [[nodiscard]] Refusal judge(const Credentials& given);

 private:
  [[nodiscard]] bool names_this_host(std::string host) const;
  [[nodiscard]] bool knows_token(const Credentials& given) const;

  const std::string token_, host_;
  RateLimit guests_, strangers_;
};

}  // namespace wayfare::examples
