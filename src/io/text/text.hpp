#pragma once

// Private: lines, tokens and numbers of text files, without copies and without locales.

#include <algorithm>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace wayfare::io::text {

inline bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// Without blanks at either end.
inline std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

/// Splits text at '\n'; the last line may lack one. A byte order mark (UTF-8) before it is skipped.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {
    if (rest_.starts_with("\xef\xbb\xbf")) rest_.remove_prefix(3);
  }

  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    terminated_ = end != std::string_view::npos;
    line = rest_.substr(0, end);
    rest_.remove_prefix(terminated_ ? end + 1 : rest_.size());
    ++number_;
    return true;
  }
  /// Number of the current line, from 1.
  [[nodiscard]] std::size_t number() const { return number_; }
  /// Whether the current line ended in '\n'.
  [[nodiscard]] bool terminated() const { return terminated_; }

 private:
  std::string_view rest_;
  std::size_t number_ = 0;
  bool terminated_ = true;
};

/// Whether a number beyond the range of its type is too small for it, not too large; `max_digits`
/// are those before the point of its largest number.
inline bool underflows(std::string_view number, int max_digits) {
  number.remove_prefix(std::min(number.find_first_not_of("-0"), number.size()));
  const std::size_t digits = std::min(number.find_first_not_of("0123456789"), number.size());
  const std::size_t exponent = number.find_first_of("eE");
  if (exponent == number.npos) return digits == 0;
  return number.substr(exponent + 1).starts_with('-') && std::cmp_less_equal(digits, max_digits);
}

/// All of `token` as a number in the C locale; a leading '+' is allowed. Else `value` is unchanged.
template <class T>
bool to_number(std::string_view token, T& value) {
  if (token.size() > 1 && token[0] == '+' && token[1] != '-') token.remove_prefix(1);
  const char* end = token.data() + token.size();
  T parsed{};
  const auto [stop, error] = std::from_chars(token.data(), end, parsed);
  if (token.empty() || stop != end) return false;
  if (error == std::errc()) {
    value = parsed;
    return true;
  }
  if constexpr (std::floating_point<T>) {
    // Underflow gives zero; overflow is rejected.
    if (!underflows(token, std::numeric_limits<T>::max_exponent10)) return false;
    value = T(0);
    return true;
  }
  return false;
}

/// Splits a line at blanks.
class Tokens {
 public:
  explicit Tokens(std::string_view line) : rest_(line) {}

  /// Empty at the end of the line.
  std::string_view next() {
    std::size_t begin = 0;
    while (begin < rest_.size() && is_space(rest_[begin])) ++begin;
    std::size_t end = begin;
    while (end < rest_.size() && !is_space(rest_[end])) ++end;
    const std::string_view token = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    return token;
  }
  template <class T>
  bool number(T& value) {
    return to_number(next(), value);
  }
  [[nodiscard]] bool at_end() const { return std::all_of(rest_.begin(), rest_.end(), is_space); }

 private:
  std::string_view rest_;
};

/// A line with '.' in place of each ',' between two digits: numbers printed by a program whose locale
/// has decimal commas.
inline std::string with_decimal_points(std::string_view line) {
  const auto is_digit = [&](std::size_t i) { return line[i] >= '0' && line[i] <= '9'; };
  std::string result(line);
  for (std::size_t i = 1; i + 1 < line.size(); ++i)
    if (line[i] == ',' && is_digit(i - 1) && is_digit(i + 1)) result[i] = '.';
  return result;
}

/// `text` for use in a message: truncated, with '.' for bytes that are not printable ASCII.
inline std::string printable(std::string_view text, std::size_t limit = 40) {
  std::string result(text.substr(0, limit));
  for (char& c : result)
    if (c < 0x20 || c > 0x7e) c = '.';
  if (text.size() > limit) result += "...";
  return result;
}

/// Appends the shortest text that reads back as the same number.
template <class T>
void append_number(std::string& out, T value) {
  char buffer[40];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value);
  out.append(buffer, end);
}

/// Appends each number after a blank.
template <class Numbers = std::initializer_list<double>>
void append_numbers(std::string& out, const Numbers& numbers) {
  for (const double v : numbers) {
    out += ' ';
    append_number(out, v);
  }
}

/// `value` with a fixed number of decimals.
inline std::string fixed(double value, int decimals) {
  char buffer[400];
  const auto [end, error] =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals);
  return {buffer, end};
}

inline constexpr std::string_view kBase64Digits =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

inline std::string to_base64(std::string_view bytes) {
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t block = 0;
    for (std::size_t k = i; k < i + 3; ++k)
      block = block << 8 | (k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : kBase64Digits[block >> (18 - 6 * k) & 63U];
  }
  return out;
}

}  // namespace wayfare::io::text
