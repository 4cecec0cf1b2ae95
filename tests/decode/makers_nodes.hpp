#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <wayfare/decode/rplidar_points.hpp>

namespace wayfare::decode {

/// The makers' state machine for nodes: bits are looked at byte by byte, nothing else is.
template <class Sink>
void makers_nodes(std::span<const std::uint8_t> bytes, Sink&& sink) {
  std::array<std::uint8_t, 5> held{};
  std::size_t n = 0;
  for (const std::uint8_t byte : bytes) {
    if (n == 0 && ((byte >> 1 ^ byte) & 1) == 0) continue;
    if (n == 1 && (byte & 1) == 0) {
      n = 0;
      continue;
    }
    held[n++] = byte;
    if (n < 5) continue;
    sink(RplidarPoint{static_cast<std::uint16_t>((held[1] | held[2] << 8) >> 1),
                      static_cast<std::uint32_t>(held[3] | held[4] << 8),
                      static_cast<std::uint8_t>(held[0] >> 2), (held[0] & 1) != 0});
    n = 0;
  }
}

}  // namespace wayfare::decode
