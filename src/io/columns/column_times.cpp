#include "io/columns/column_times.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <string>

#include "io/text/lines.hpp"
#include "io/text/text.hpp"

namespace wayfare::io {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

/// Whole numbers separated by `separator`: "2025/07/08".
template <std::size_t kCount>
bool whole_numbers(std::string_view token, char separator, std::array<int, kCount>& values) {
  for (std::size_t i = 0; i < kCount; ++i) {
    const std::size_t end = i + 1 < kCount ? token.find(separator) : token.size();
    if (end == token.npos || !text::to_number(token.substr(0, end), values[i])) return false;
    token.remove_prefix(std::min(token.size(), end + 1));
  }
  return true;
}

}  // namespace

std::optional<std::int64_t> decimal_ns(std::string_view token, int decimals) {
  if (decimals == 0) return parse_nanoseconds(token);
  if (token.find_first_of("eE") != token.npos) return std::nullopt;
  return parse_nanoseconds(std::string(token) + "e-" + std::to_string(decimals));
}

std::optional<std::int64_t> date_seconds(std::string_view token) {
  std::array<int, 3> d{};
  if (!whole_numbers(token, '/', d) && !whole_numbers(token, '-', d)) return std::nullopt;
  if (d[0] < 1900 || d[0] > 2100 || d[1] < 1 || d[2] < 1) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(d[0]),
                                         std::chrono::month(static_cast<unsigned>(d[1])),
                                         std::chrono::day(static_cast<unsigned>(d[2]))};
  if (!date.ok()) return std::nullopt;
  return std::int64_t{86400} * std::chrono::sys_days(date).time_since_epoch().count();
}

std::optional<std::int64_t> clock_ns(std::string_view token) {
  const std::size_t last = token.rfind(':');
  std::array<int, 2> hm{};
  if (last == token.npos || !whole_numbers(token.substr(0, last), ':', hm)) return std::nullopt;
  const std::optional<std::int64_t> s = parse_nanoseconds(token.substr(last + 1));
  if (!s || *s < 0 || *s >= 61 * kSecond_ns || hm[0] < 0 || hm[0] > 23 || hm[1] < 0 || hm[1] > 59)
    return std::nullopt;
  return (hm[0] * 3600 + hm[1] * 60) * kSecond_ns + *s;
}

}  // namespace wayfare::io
