#include <wayfare/io/text_file.hpp>

#include <algorithm>
#include <limits>

#include "io/text/text.hpp"

namespace wayfare::io {
namespace {

/// Moves leading digits of `text` to the end of `digits`; returns their number.
long take_digits(std::string_view& text, std::string& digits) {
  const std::size_t count = std::min(text.find_first_not_of("0123456789"), text.size());
  digits += text.substr(0, count);
  text.remove_prefix(count);
  return static_cast<long>(count);
}

/// The power of ten after 'e', 0 where there is none; nullopt where it is malformed.
std::optional<int> take_exponent(std::string_view text) {
  if (text.empty()) return 0;
  if (text.front() != 'e' && text.front() != 'E') return std::nullopt;
  int exponent = 0;
  if (!text::to_number(text.substr(1), exponent)) return std::nullopt;
  if (exponent < -1000 || exponent > 1000) return std::nullopt;
  return exponent;
}

/// 0.d1d2d3... · 10^places rounded to a whole number of at most `max`.
std::optional<std::uint64_t> rounded(const std::string& digits, long places, std::uint64_t max) {
  std::uint64_t value = 0;
  for (long i = 0; i < places; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const std::uint64_t digit = at < digits.size() ? static_cast<unsigned>(digits[at] - '0') : 0U;
    if (value > (max - digit) / 10) return std::nullopt;
    value = value * 10 + digit;
  }
  const bool up = places >= 0 && places < static_cast<long>(digits.size()) &&
                  digits[static_cast<std::size_t>(places)] >= '5';
  if (up && value == max) return std::nullopt;
  return value + (up ? 1 : 0);
}

}  // namespace

std::optional<std::int64_t> parse_nanoseconds(std::string_view seconds) {
  constexpr std::size_t kLongest = 400;  // limits the work on malformed input
  if (seconds.size() > kLongest) return std::nullopt;
  bool negative = false;
  if (!seconds.empty() && (seconds.front() == '-' || seconds.front() == '+')) {
    negative = seconds.front() == '-';
    seconds.remove_prefix(1);
  }
  std::string digits;
  long places = take_digits(seconds, digits);
  if (!seconds.empty() && seconds.front() == '.') {
    seconds.remove_prefix(1);
    take_digits(seconds, digits);
  }
  if (digits.empty()) return std::nullopt;
  const std::optional<int> exponent = take_exponent(seconds);
  if (!exponent) return std::nullopt;
  const std::size_t zeros = digits.find_first_not_of('0');
  if (zeros == digits.npos) return 0;
  places += *exponent + 9 - static_cast<long>(zeros);
  // The most negative number has no positive counterpart.
  constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  const auto value = rounded(digits.substr(zeros), places, negative ? kMax + 1 : kMax);
  if (!value) return std::nullopt;
  return static_cast<std::int64_t>(negative ? 0 - *value : *value);
}

std::string format_nanoseconds(std::int64_t nanoseconds) {
  const bool negative = nanoseconds < 0;
  // Unsigned, since the absolute value of the most negative number does not fit int64.
  const auto bits = static_cast<std::uint64_t>(nanoseconds);
  std::string text = std::to_string(negative ? 0 - bits : bits);
  if (text.size() < 10) text.insert(0, 10 - text.size(), '0');
  text.insert(text.size() - 9, 1, '.');
  return negative ? "-" + text : text;
}

}  // namespace wayfare::io
