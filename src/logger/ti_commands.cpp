#include <wayfare/logger/ti_commands.hpp>

#include <array>
#include <chrono>
#include <cstdint>
#include <thread>

#include <wayfare/decode/ti_commands.hpp>

#include "logger/configure.hpp"

namespace wayfare::logger {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// All of it before `until`.
Result<void> write_all(SerialPort& port, std::string_view text, Clock::time_point until) {
  while (!text.empty()) {
    const auto n = port.write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    if (!n) return n.error();
    text.remove_prefix(*n);
    if (*n != 0) continue;
    if (Clock::now() >= until) return Error{ErrorCode::io, "the command port takes no bytes"};
    std::this_thread::sleep_for(milliseconds(2));
  }
  return {};
}

}  // namespace

Result<void> send_ti_config(SerialPort& port, std::string_view config, const std::string& source,
                            Duration timeout, const std::atomic<bool>* stop) {
  decode::TiDialogue dialogue(config, source);
  std::array<std::uint8_t, 512> buffer{};
  while (const auto command = dialogue.next()) {
    const auto until = Clock::now() + timeout;
    if (auto sent = write_all(port, std::string(*command) + '\n', until); !sent) return sent;
    const std::size_t before = dialogue.answered();
    while (dialogue.answered() == before && !dialogue.error()) {
      if (stop != nullptr && *stop) return Error{ErrorCode::cancelled, "stopped", source};
      if (Clock::now() >= until) return dialogue.no_answer();
      const auto n = port.read(buffer, milliseconds(20));
      if (!n) return n.error();
      dialogue.feed({reinterpret_cast<const char*>(buffer.data()), *n});
    }
  }
  if (dialogue.error()) return *dialogue.error();
  return {};
}

Result<void> configure(const SensorOptions& sensor, const std::atomic<bool>& stop) {
  if (sensor.command_port.empty()) return {};
  auto commands = SerialPort::open(sensor.command_port);
  if (!commands) return commands.error();
  return send_ti_config(*commands, sensor.device.configuration,
                        "configuration of " + sensor.device.name, std::chrono::seconds(2), &stop);
}

}  // namespace wayfare::logger
