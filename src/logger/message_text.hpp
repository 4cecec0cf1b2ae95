#pragma once

// Parts of JSON messages.

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/logger/messages.hpp>

#include "io/text/text.hpp"
#include "logger/time_parts.hpp"

namespace wayfare::logger::message_text {

inline constexpr std::int64_t kSecond = 1'000'000'000;
inline constexpr std::string_view kNoPose =
    R"(,"pose":{"position":{"x":0,"y":0,"z":0},"orientation":{"x":0,"y":0,"z":0,"w":1}})";

inline Error malformed(const char* what) {
  return Error{ErrorCode::parse, std::string("is no ") + what};
}

/// The shortest text that is read back as the same number.
template <class Number>
void put(std::string& out, Number value) {
  if (std::isfinite(value)) {
    io::text::append_number(out, value);
  } else {
    out += "null";
  }
}

/// The beginning of a message: its time and frame.
inline std::string head(LogTime time, std::string_view frame) {
  const auto [sec, nsec] = seconds_and_rest(time);
  std::string out = R"({"timestamp":{"sec":)";
  put(out, sec);
  out += R"(,"nsec":)";
  put(out, nsec);
  out += R"(},"frame_id":")" + json_escaped(frame) + '"';
  return out;
}

/// Numbers x, y, z, and those in `more`, as properties of a schema.
inline std::string numbers(std::string_view more = {}) {
  std::string out;
  for (const char c : std::string("xyz") + std::string(more))
    out += std::string(out.empty() ? "" : ",") + '"' + c + R"(":{"type":"number"})";
  return out;
}

/// The schema of a message with time, frame, optional pose, and `fields`.
inline std::string schema_json(const std::string& name, bool posed, const std::string& fields) {
  std::string out = R"({"title":")" + name + R"(","type":"object","properties":{)";
  out += R"("timestamp":{"type":"object","title":"time","properties":)";
  out += R"({"sec":{"type":"integer"},"nsec":{"type":"integer"}}},"frame_id":{"type":"string"},)";
  if (posed) {
    out += R"("pose":{"title":"foxglove.Pose","type":"object","properties":{)";
    out += R"("position":{"title":"foxglove.Vector3","type":"object","properties":{)" + numbers() +
           R"(}},"orientation":{"title":"foxglove.Quaternion","type":"object","properties":{)" +
           numbers("w") + "}}}},";
  }
  return out + fields + "}}";
}

inline std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text) {
  std::vector<std::uint8_t> out;
  std::uint32_t bits = 0;
  int held = 0;
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  for (const char c : text) {
    const std::size_t value = io::text::kBase64Digits.find(c);
    if (value == text.npos) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    out.push_back(static_cast<std::uint8_t>(bits >> held));
  }
  return out;
}

inline std::optional<double> number(const nlohmann::json& from, const char* key) {
  const auto it = from.find(key);
  if (it == from.end() || !it->is_number()) return std::nullopt;
  return it->get<double>();
}

inline std::optional<LogTime> time_of(const nlohmann::json& message) {
  const auto it = message.find("timestamp");
  if (it == message.end() || !it->is_object()) return std::nullopt;
  const auto sec = it->find("sec"), nsec = it->find("nsec");
  if (sec == it->end() || nsec == it->end() || !sec->is_number_integer() ||
      !nsec->is_number_integer())
    return std::nullopt;
  // An unsigned number above the limit of a signed one would be taken for a negative one.
  const auto too_large = [](const nlohmann::json& n) {
    return n.is_number_unsigned() && n.get<std::uint64_t>() > 9'000'000'000;
  };
  if (too_large(*sec) || too_large(*nsec)) return std::nullopt;
  const auto s = sec->get<std::int64_t>(), ns = nsec->get<std::int64_t>();
  if (s < -9'000'000'000 || s > 9'000'000'000 || ns < 0 || ns >= kSecond) return std::nullopt;
  return LogTime::from_nanoseconds(s * kSecond + ns);
}

/// The bytes of a number, the least significant first.
template <class Number>
void append_le(std::string& out, Number value) {
  std::array<std::uint8_t, sizeof value> raw;
  decode::store_le(value, raw.data());
  out.append(raw.begin(), raw.end());
}

}  // namespace wayfare::logger::message_text
