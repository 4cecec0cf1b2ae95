#pragma once

// Objects in JSON files.

#include <algorithm>
#include <cstddef>
#include <string>

#include <nlohmann/json.hpp>

#include <wayfare/core/result.hpp>

namespace wayfare::examples {

/// An object of a file named `source`, which may have comments. Errors: not JSON, with line and
/// byte; another value than an object.
template <class Json>
[[nodiscard]] Result<Json> parse_json_object(const std::string& text, const std::string& source) {
  try {
    Json json = Json::parse(text, nullptr, true, true);
    if (json.is_object()) return json;
    return Error{ErrorCode::parse, "expected a JSON object, not " + std::string(json.type_name()),
                 source};
  } catch (const nlohmann::json::parse_error& error) {
    // "[json.exception.parse_error.101] parse error at line 2, column 3: " and the reason.
    const std::string what = error.what();
    const std::size_t place = what.find(": ");
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(error.byte, text.size()));
    return Error{ErrorCode::parse, "not JSON: " + what.substr(place == what.npos ? 0 : place + 2),
                 source, 1 + static_cast<std::size_t>(std::count(text.begin(), end, '\n')),
                 error.byte};
  }
}

}  // namespace wayfare::examples
