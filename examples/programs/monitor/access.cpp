#include "access.hpp"

#include <algorithm>
#include <cstddef>
#include <random>

namespace wayfare::examples {
namespace {

/// In constant time.
bool same(const std::string& a, const std::string& b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^
                  static_cast<unsigned char>(b.empty() ? 0 : b[i % b.size()]);
  return difference == 0;
}

}  // namespace

bool is_loopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host == "[::1]" || host.rfind("127.", 0) == 0;
}

std::string random_token() {
  std::random_device random;
  std::string token;
  for (int i = 0; i < 32; ++i) token += "0123456789abcdef"[random() % 16U];
  return token;
}

bool RateLimit::take() {
  const std::lock_guard lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  const std::chrono::duration<double> since = now - last_;
  last_ = now;
  left_ = std::min(2.0 * per_s_, left_ + per_s_ * since.count());
  if (left_ < 1.0) return false;
  left_ -= 1.0;
  return true;
}

Refusal Access::judge(const Credentials& given) {
  const bool here = names_this_host(given.host), known = knows_token(given);
  if (!(here && known ? guests_ : strangers_).take()) return {429, "too many requests"};
  if (!here) return {403, "this is another host"};
  if (!known) return {401, "the token is missing or wrong"};
  return {};
}

/// Without a token, pages of other sites must not reach this server by DNS rebinding.
bool Access::names_this_host(std::string host) const {
  if (!token_.empty()) return true;
  const auto colon = host.rfind(':');
  if (colon != host.npos && host.find(']', colon) == host.npos) host.resize(colon);
  return is_loopback(host) || host == host_;
}

bool Access::knows_token(const Credentials& given) const {
  if (token_.empty()) return true;
  constexpr std::size_t kBearer = 7;
  if (given.authorization.rfind("Bearer ", 0) == 0 &&
      same(given.authorization.substr(kBearer), token_))
    return true;
  return same(given.token, token_);
}

}  // namespace wayfare::examples
