#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include <wayfare/core/time.hpp>
#include <wayfare/io/time_text.hpp>

namespace wayfare::io {

/// Stamps are within 126 years of the epoch, so that the difference of any two fits 64 bits.
inline constexpr std::int64_t kLargestStamp_ns = 4'000'000'000'000'000'000;

/// A time stamp of a file.
inline std::optional<LogTime> parse_stamp(std::string_view token) {
  const std::optional<std::int64_t> ns = parse_nanoseconds(token);
  if (!ns || *ns > kLargestStamp_ns || *ns < -kLargestStamp_ns) return std::nullopt;
  return LogTime::from_nanoseconds(*ns);
}

}  // namespace wayfare::io
