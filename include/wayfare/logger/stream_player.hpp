#pragma once

// Devices that are not there: recorded bytes into a pseudo-terminal, in their time or a multiple.

#include <atomic>
#include <cstdint>
#include <vector>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/logger/serial_port.hpp>

namespace wayfare::logger {

/// Bytes and when they come, since the beginning.
struct TimedBytes {
  Duration at{0};
  decode::Bytes bytes;
};

/// A capture without times as a device of that rate would send it, `piece` bytes at once.
[[nodiscard]] std::vector<TimedBytes> at_rate(decode::Bytes bytes, double bytes_per_s,
                                              std::size_t piece = 256);

/// Writes all of it, `speed` times as fast as it came, and waits where the reader is slower. Gives
/// how many bytes were written: fewer where `stop` was set.
[[nodiscard]] Result<std::uint64_t> play(PseudoTerminal& terminal,
                                         const std::vector<TimedBytes>& stream, double speed,
                                         const std::atomic<bool>& stop);

}  // namespace wayfare::logger
