#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace wayfare::io {

/// Seconds in decimal text, such as "976052857.137530" or "1.2e3", as whole nanoseconds, without a
/// floating-point intermediate; digits beyond the ninth decimal are rounded (half away from zero).
/// nullopt where it is not such a number or does not fit 64 bits.
[[nodiscard]] std::optional<std::int64_t> parse_nanoseconds(std::string_view seconds);

/// Nanoseconds as seconds with nine decimals, exact: "976052857.137530000".
[[nodiscard]] std::string format_nanoseconds(std::int64_t nanoseconds);

}  // namespace wayfare::io
