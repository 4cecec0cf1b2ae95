#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <wayfare/decode/rplidar_scan.hpp>

namespace wayfare::decode {

/// The maker's state machine for nodes, which checks only their bits, byte by byte.
template <class Sink>
void makers_nodes(std::span<const std::uint8_t> bytes, Sink&& sink) {
  std::array<std::uint8_t, 5> node{};
  std::size_t n = 0;
  for (const std::uint8_t byte : bytes) {
    if (n == 0 && ((byte >> 1 ^ byte) & 1) == 0) continue;
    if (n == 1 && (byte & 1) == 0) {
      n = 0;
      continue;
    }
    node[n++] = byte;
    if (n < 5) continue;
    sink(RplidarPoint{static_cast<std::uint16_t>((node[1] | node[2] << 8) >> 1),
                      static_cast<std::uint32_t>(node[3] | node[4] << 8),
                      static_cast<std::uint8_t>(node[0] >> 2), (node[0] & 1) != 0});
    n = 0;
  }
}

}  // namespace wayfare::decode
