#pragma once

#include <cstdint>

#include <wayfare/core/time.hpp>

namespace wayfare::decode {

/// Time that `bytes` take on a line of `baud`: start bit, eight bits, stop bit each.
[[nodiscard]] inline Duration line_time(std::uint64_t bytes, int baud) {
  return from_seconds(10.0 * static_cast<double>(bytes) / static_cast<double>(baud));
}

}  // namespace wayfare::decode
