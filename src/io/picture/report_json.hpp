#pragma once

// Private: the blocks of a report as JSON.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <wayfare/io/report.hpp>

namespace wayfare::io::json {

/// In quotes; control characters and quotes escaped, invalid UTF-8 replaced.
[[nodiscard]] std::string text(std::string_view text);
/// The shortest number that reads back as `value`; null if it is not finite.
[[nodiscard]] std::string number(double value);

[[nodiscard]] std::string heading(const std::string& text);
[[nodiscard]] std::string paragraph(const std::string& text);
[[nodiscard]] std::string image(const std::string& caption);
[[nodiscard]] std::string facts(const std::vector<std::pair<std::string, std::string>>& facts);
[[nodiscard]] std::string table(const eval::Table& table, const std::string& caption);
[[nodiscard]] std::string plot(const Plot& plot);

}  // namespace wayfare::io::json
