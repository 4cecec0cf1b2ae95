#pragma once

// Little-endian numbers in recordings.

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace wayfare::io {

template <std::unsigned_integral T>
void put(std::string& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    out += static_cast<char>(static_cast<std::uint8_t>(std::uint64_t{value} >> (8 * i)));
}

/// Preceded by its length in four bytes.
inline void put_text(std::string& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out += text;
}

/// Reads numbers, and texts preceded by their length. Past the end all values are zero or empty and
/// `ok` is false.
class ByteCursor {
 public:
  explicit ByteCursor(std::string_view bytes) : rest_(bytes) {}

  template <std::unsigned_integral T>
  T number() {
    const std::string_view b = bytes(sizeof(T));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < b.size(); ++i)
      value |= std::uint64_t{static_cast<std::uint8_t>(b[i])} << (8 * i);
    return static_cast<T>(value);
  }

  std::string_view bytes(std::uint64_t n) {
    if (n > rest_.size()) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(n));
    rest_.remove_prefix(taken.size());
    return taken;
  }

  std::string_view text() { return bytes(number<std::uint32_t>()); }

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 protected:
  void fail() { ok_ = false; }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace wayfare::io
