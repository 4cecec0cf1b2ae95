#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace wayfare::io {

/// A decimal number of 10^-decimals seconds, exact.
[[nodiscard]] std::optional<std::int64_t> decimal_ns(std::string_view token, int decimals);

/// Seconds from 1970-01-01 to midnight of "2025/07/08" or "2025-07-08".
[[nodiscard]] std::optional<std::int64_t> date_seconds(std::string_view token);

/// Nanoseconds of "19:34:18.499".
[[nodiscard]] std::optional<std::int64_t> clock_ns(std::string_view token);

}  // namespace wayfare::io
