#pragma once

// Configuration of a TI mmWave sensor through its command port.

#include <atomic>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/logger/serial_port.hpp>

namespace wayfare::logger {

/// Sends the commands of a .cfg one after the other and checks each answer. Errors: a command that
/// the sensor refuses, with its line in `source` and the answer; one that is not answered within
/// `timeout`; the line is closed; `stop` was set.
[[nodiscard]] Result<void> send_ti_config(SerialPort& port, std::string_view config,
                                          const std::string& source,
                                          Duration timeout = std::chrono::seconds(2),
                                          const std::atomic<bool>* stop = nullptr);

}  // namespace wayfare::logger
