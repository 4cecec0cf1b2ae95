#include "logger/message_text.hpp"

#include <limits>

#include <nlohmann/json.hpp>

#include <wayfare/logger/messages.hpp>

#include "io/text/text.hpp"

namespace wayfare::logger::text {

using nlohmann::json;

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

}  // namespace

std::string head(LogTime time, std::string_view frame) {
  const std::int64_t ns = time.nanoseconds();
  const std::int64_t rest = (ns % kSecond + kSecond) % kSecond;
  std::string out = R"({"timestamp":{"sec":)";
  put(out, (ns - rest) / kSecond);
  out += R"(,"nsec":)";
  put(out, rest);
  out += R"(},"frame_id":")" + json_escaped(frame) + '"';
  return out;
}

std::string numbers(std::string_view more) {
  std::string out;
  for (const char c : std::string("xyz") + std::string(more))
    out += std::string(out.empty() ? "" : ",") + '"' + c + R"(":{"type":"number"})";
  return out;
}

std::string schema_json(const std::string& name, bool posed, const std::string& fields) {
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

std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text) {
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

std::optional<double> number(const json& from, const char* key) {
  const auto it = from.find(key);
  if (it == from.end() || !it->is_number()) return std::nullopt;
  return it->get<double>();
}

std::optional<LogTime> time_of(const json& message) {
  const auto it = message.find("timestamp");
  if (it == message.end() || !it->is_object()) return std::nullopt;
  const auto sec = it->find("sec"), nsec = it->find("nsec");
  if (sec == it->end() || nsec == it->end() || !sec->is_number_integer() ||
      !nsec->is_number_integer())
    return std::nullopt;
  const auto s = sec->get<std::int64_t>(), ns = nsec->get<std::int64_t>();
  if (s < -9'000'000'000 || s > 9'000'000'000 || ns < 0 || ns >= kSecond) return std::nullopt;
  return LogTime::from_nanoseconds(s * kSecond + ns);
}

std::optional<Eigen::Vector3d> vector_of(const json& message, const char* key) {
  const auto it = message.find(key);
  if (it == message.end() || it->is_null()) return Eigen::Vector3d::Constant(MargSample::kNone);
  if (!it->is_object()) return std::nullopt;
  const auto x = number(*it, "x"), y = number(*it, "y"), z = number(*it, "z");
  if (!x || !y || !z) return std::nullopt;
  return Eigen::Vector3d(*x, *y, *z);
}

}  // namespace wayfare::logger::text
