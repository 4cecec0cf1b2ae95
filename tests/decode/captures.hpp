#pragma once

// Captures of devices for the tests: whole files, decompressed.

#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/io/text_file.hpp>
#include "io/support.hpp"

namespace wayfare::testing {

inline std::string file_text(const std::string& path) {
  auto content = io::read_file(path);
  EXPECT_TRUE(content) << (content ? "" : content.error().to_string());
  return content ? content->bytes : std::string();
}

inline std::vector<std::uint8_t> file_bytes(const std::string& path) {
  const std::string text = file_text(path);
  return {text.begin(), text.end()};
}

/// A fingerprint of bytes (FNV-1a), to compare messages.
inline std::string fingerprint(decode::Bytes bytes) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const std::uint8_t byte : bytes) hash = (hash ^ byte) * 0x100000001b3ULL;
  return std::to_string(hash);
}

}  // namespace wayfare::testing

namespace wayfare::decode {

using Stream = std::vector<std::uint8_t>;

inline void append(Stream& to, const Stream& more) {
  to.insert(to.end(), more.begin(), more.end());
}

/// A decoded message as text: text_of() of its type.
inline constexpr auto kAsText = [](const auto& message) { return text_of(message); };

}  // namespace wayfare::decode
