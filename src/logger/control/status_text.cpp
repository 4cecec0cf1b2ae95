#include <cmath>
#include <string>

#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/messages.hpp>

namespace wayfare::logger {
namespace {

std::string number(double value) {
  std::string text = std::to_string(std::isfinite(value) ? value : 0.0);
  return text.substr(0, text.find('.') + 2);
}

}  // namespace

const char* name_of(LoggerState state) {
  switch (state) {
    case LoggerState::idle:
      return "idle";
    case LoggerState::starting:
      return "starting";
    case LoggerState::recording:
      return "recording";
    case LoggerState::stopping:
      return "stopping";
    case LoggerState::failed:
      return "failed";
    default:
      return "terminated";
  }
}

const char* name_of(SensorState state) {
  switch (state) {
    case SensorState::waiting:
      return "waiting";
    case SensorState::silent:
      return "silent";
    default:
      return "receiving";
  }
}

std::string to_json(const LoggerStatus& status) {
  const auto text = [](const std::string& s) { return '"' + json_escaped(s) + '"'; };
  const std::int64_t ns = status.time.nanoseconds();
  std::string out = "{\"state\":" + text(name_of(status.state));
  out += ",\"timestamp\":{\"sec\":" + std::to_string(ns / 1'000'000'000) +
         ",\"nsec\":" + std::to_string(ns % 1'000'000'000) + '}';
  out += ",\"file\":" + text(status.file) + ",\"seconds\":" + number(status.seconds);
  out += ",\"written\":" + std::to_string(status.written);
  out += ",\"disk_free\":" + std::to_string(status.disk_free);
  out += ",\"queued\":" + std::to_string(status.queued);
  out += ",\"queue_peak\":" + std::to_string(status.queue_peak);
  out += ",\"dropped\":" + std::to_string(status.dropped);
  out += ",\"error\":" + text(status.error) + ",\"sensors\":[";
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
    out += ",\"sample\":" + text(s.decoding.sample) + ",\"note\":" + text(s.note) + '}';
  }
  return out + "]}";
}

}  // namespace wayfare::logger
