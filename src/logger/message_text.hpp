#pragma once

// JSON elements for writing and reading messages.

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include <wayfare/core/time.hpp>

namespace wayfare::logger::text {

/// The shortest text that is read back as the same number.
template <class Number>
void put(std::string& out, Number value) {
  if constexpr (std::is_floating_point_v<Number>) {
    if (!std::isfinite(value)) {
      out += "null";
      return;
    }
  }
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value);
  out.append(text.data(), end.ptr);
}

/// The beginning of a message: its time and frame.
[[nodiscard]] std::string head(LogTime time, std::string_view frame);

constexpr std::string_view kNoPose =
    R"(,"pose":{"position":{"x":0,"y":0,"z":0},"orientation":{"x":0,"y":0,"z":0,"w":1}})";

/// Numbers x, y, z, and those in `more`, as properties of a schema.
[[nodiscard]] std::string numbers(std::string_view more = {});
/// The schema of a message with time, frame, optional pose, and `fields`.
[[nodiscard]] std::string schema_json(const std::string& name, bool posed,
                                      const std::string& fields);

[[nodiscard]] std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text);

[[nodiscard]] std::optional<double> number(const nlohmann::json& from, const char* key);
[[nodiscard]] std::optional<LogTime> time_of(const nlohmann::json& message);
/// Three numbers, NaN if the field is null or missing; nothing if it is something else.
[[nodiscard]] std::optional<Eigen::Vector3d> vector_of(const nlohmann::json& message,
                                                       const char* key);

}  // namespace wayfare::logger::text
