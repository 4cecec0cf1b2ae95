#pragma once

// Simulated devices: recorded bytes in a pseudo-terminal, in real time or faster.

#include <atomic>
#include <cstdint>
#include <vector>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/logger/serial_port.hpp>

namespace wayfare::logger {

/// Bytes and their time since the beginning.
struct TimedBytes {
  Duration at{0};
  decode::Bytes bytes;
};

/// A capture without times as sent by a device of that rate, `piece` bytes at a time.
[[nodiscard]] std::vector<TimedBytes> at_rate(decode::Bytes bytes, double bytes_per_s,
                                              std::size_t piece = 256);

/// Writes all of it at `speed` times its rate, waiting for a slower reader. Returns the number of
/// bytes written: fewer if `stop` was set.
[[nodiscard]] Result<std::uint64_t> play(PseudoTerminal& terminal,
                                         const std::vector<TimedBytes>& stream, double speed,
                                         const std::atomic<bool>& stop);

}  // namespace wayfare::logger
