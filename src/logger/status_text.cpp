#include <zlib.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <string>

#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/messages.hpp>

#include "logger/time_parts.hpp"

namespace wayfare::logger {
namespace {

/// CRC-32 in eight hexadecimal digits.
std::string checksum(std::string_view bytes) {
  const auto sum =
      ::crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size()));
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%08x", static_cast<unsigned>(sum));
  return text.data();
}

/// One decimal, cut off. Independent of the locale, whose decimal point may be another.
std::string number(double value) {
  std::array<char, 400> text{};  // the longest has 309 digits before the point
  char* const end = std::to_chars(text.data(), text.data() + text.size(),
                                  std::isfinite(value) ? value : 0.0, std::chars_format::fixed, 6)
                        .ptr;
  return std::string(text.data(), end - 5);
}

}  // namespace

std::optional<Command> command_of(std::uint8_t byte) {
  for (const Command command : {Command::begin, Command::stop, Command::terminate, Command::check})
    if (byte == static_cast<std::uint8_t>(command)) return command;
  return std::nullopt;
}

std::string status_line(std::string_view json) {
  return std::string(json) + '*' + checksum(json) + '\n';
}

std::optional<std::string_view> status_of_line(std::string_view line) {
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.remove_suffix(1);
  if (line.size() < 9 || line[line.size() - 9] != '*') return std::nullopt;
  const std::string_view json = line.substr(0, line.size() - 9);
  if (line.substr(line.size() - 8) != checksum(json)) return std::nullopt;
  return json;
}

const char* name_of(LoggerState state) {
  constexpr std::array kNames = {"idle",     "starting", "recording",
                                 "stopping", "failed",   "terminated"};
  return kNames[static_cast<std::size_t>(state)];
}

const char* name_of(SensorState state) {
  constexpr std::array kNames = {"waiting", "silent", "receiving"};
  return kNames[static_cast<std::size_t>(state)];
}

std::string to_json(const LoggerStatus& status) {
  constexpr std::size_t kRoom = 3000;  // a serial line's buffer takes 4 kB at once
  const auto text = [](const std::string& s) { return '"' + json_escaped(s) + '"'; };
  const auto [sec, nsec] = seconds_and_rest(status.time);
  std::string out = "{\"state\":" + text(name_of(status.state));
  out +=
      ",\"timestamp\":{\"sec\":" + std::to_string(sec) + ",\"nsec\":" + std::to_string(nsec) + '}';
  out += ",\"file\":" + text(status.file) + ",\"files\":" + std::to_string(status.files);
  out += ",\"seconds\":" + number(status.seconds);
  out += ",\"written\":" + std::to_string(status.written);
  out += ",\"disk_free\":" + std::to_string(status.disk_free);
  out += ",\"queued\":" + std::to_string(status.queued);
  out += ",\"queue_peak\":" + std::to_string(status.queue_peak);
  out += ",\"dropped\":" + std::to_string(status.dropped);
  out += ",\"error\":" + text(status.error) + ",\"warning\":" + text(status.warning);
  out += ",\"sensors\":[";
  for (const SensorStatus& s : status.sensors) {
    if (&s != &status.sensors.front()) out += ',';
    out += "{\"name\":" + text(s.name) + ",\"state\":" + text(name_of(s.state));
    out += ",\"bytes\":" + std::to_string(s.bytes);
    out += ",\"recorded\":" + std::to_string(s.recorded_bytes);
    out += ",\"dropped\":" + std::to_string(s.dropped);
    out += ",\"bytes_per_s\":" + number(s.bytes_per_s);
    out += ",\"messages_per_s\":" + number(s.messages_per_s);
    out += ",\"messages\":" + std::to_string(s.decoding.messages);
    out += ",\"skipped_bytes\":" + std::to_string(s.decoding.skipped_bytes);
    out += ",\"damaged\":" + std::to_string(s.decoding.damaged);
    out += ",\"sample\":" + text(s.decoding.sample) + ",\"note\":" + text(s.note);
    out += ",\"warning\":" + text(s.warning);
    if (!s.decoding.latest.empty() && out.size() + s.decoding.latest.size() < kRoom)
      out += ",\"latest\":" + s.decoding.latest;
    out += '}';
  }
  return out + "]}";
}

}  // namespace wayfare::logger
