#pragma once

// Messages and contents of recordings in the form that the monitor's page reads.

#include <algorithm>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include <wayfare/core/time.hpp>
#include <wayfare/io/mcap.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/messages.hpp>

namespace wayfare::examples {

[[nodiscard]] inline std::string hexadecimal(std::string_view bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    out += {kDigits[byte >> 4], kDigits[byte & 15U]};
  }
  return out;
}

/// JSON that may hold bytes that are not UTF-8.
[[nodiscard]] inline std::string text_of(const nlohmann::json& value) {
  return value.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

/// Time of measurement, as far as it is known.
[[nodiscard]] inline LogTime measured_at(const io::McapMessage& m) {
  return m.publish_time.nanoseconds() > 0 ? m.publish_time : m.log_time;
}

/// Two lines, each after `prefix`: topic, time of logging `t` and time of measurement `m` (seconds
/// since 1970) as JSON; then the message, of bytes their number and the first of them.
[[nodiscard]] inline std::string message_lines(const io::McapMessage& m, std::string_view prefix) {
  constexpr std::size_t kMostBytes = 256;
  std::string out(prefix);
  out += "{\"topic\":\"" + logger::json_escaped(m.channel->topic) +
         "\",\"t\":" + io::format_nanoseconds(m.log_time.nanoseconds()) +
         ",\"m\":" + io::format_nanoseconds(measured_at(m).nanoseconds()) + "}\n";
  out += prefix;
  if (m.channel->message_encoding == "json") {
    const std::size_t begin = out.size();
    out += m.data;
    // Line ends in JSON are white space.
    const auto is_line_end = [](char c) { return c == '\n' || c == '\r'; };
    std::replace_if(out.begin() + static_cast<std::ptrdiff_t>(begin), out.end(), is_line_end, ' ');
  } else {
    out += "{\"bytes\":" + std::to_string(m.data.size()) + ",\"hex\":\"" +
           hexadecimal(m.data.substr(0, kMostBytes)) + "\"}";
  }
  return out + '\n';
}

/// The name of a channel's schema; without one, that of its encoding.
[[nodiscard]] inline std::string schema_of(const io::McapContents& contents,
                                           const io::McapChannel& channel) {
  for (const io::McapSchema& s : contents.schemas)
    if (s.id == channel.schema) return s.name;
  return {};
}

/// Size, times, topics with their numbers of messages, JSON schemas, and problems.
[[nodiscard]] inline std::string contents_text(const std::string& path, const io::McapContents& c) {
  using nlohmann::json;
  json out = {{"path", path},
              {"bytes", c.bytes},
              {"messages", c.statistics.messages},
              {"chunks", c.statistics.chunks},
              {"indexed", c.indexed},
              {"start_s", c.statistics.first.seconds()},
              {"seconds", to_seconds(c.statistics.last - c.statistics.first)},
              {"topics", json::array()},
              {"schemas", json::object()},
              {"problems", json::array()}};
  for (const io::McapChannel& channel : c.channels) {
    const auto count = c.statistics.messages_of.find(channel.id);
    const std::string schema = schema_of(c, channel);
    out["topics"].push_back(
        {{"topic", channel.topic},
         {"schema", schema.empty() ? channel.message_encoding : schema},
         {"messages", count == c.statistics.messages_of.end() ? 0 : count->second}});
  }
  for (const io::McapSchema& s : c.schemas)
    if (s.encoding == "jsonschema") out["schemas"][s.name] = json::parse(s.data, nullptr, false);
  for (const Error& problem : c.problems.first())
    if (out["problems"].size() < 20) out["problems"].push_back(problem.to_string());
  return text_of(out);
}

}  // namespace wayfare::examples
