#pragma once

// Configuration of a device through a port of its own.

#include <atomic>

#include <wayfare/core/result.hpp>
#include <wayfare/logger/logger.hpp>

namespace wayfare::logger {

/// Sends a TI radar's configuration to its command port, if it has one. Errors: as of
/// send_ti_config, the port cannot be opened.
[[nodiscard]] Result<void> configure(const SensorOptions& sensor, const std::atomic<bool>& stop);

}  // namespace wayfare::logger
