#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include <wayfare/core/time.hpp>
#include <wayfare/io/time_text.hpp>

namespace wayfare::io {

/// A time stamp of a file. Stamps more than 126 years from the epoch are refused: no clock gives
/// them, and the difference of any two others fits 64 bits.
inline std::optional<LogTime> parse_stamp(std::string_view token) {
  constexpr std::int64_t kLargest = 4'000'000'000'000'000'000;
  const std::optional<std::int64_t> ns = parse_nanoseconds(token);
  if (!ns || *ns > kLargest || *ns < -kLargest) return std::nullopt;
  return LogTime::from_nanoseconds(*ns);
}

}  // namespace wayfare::io
