#pragma once

// RPLIDAR byte streams built by the manual, and their decoded messages.

#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_scan.hpp>

#include "captures.hpp"

namespace wayfare::decode {

using Points = std::vector<RplidarPoint>;

inline std::string hex(Bytes bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += "0123456789ABCDEF"[byte >> 4];
    text += "0123456789ABCDEF"[byte & 15];
  }
  return text;
}

inline std::string text_of(const RplidarPacket& p) {
  return std::to_string(static_cast<int>(p.response())) + (p.is_descriptor() ? "d" : "") +
         hex(p.bytes());
}

inline Stream descriptor(RplidarResponse response, std::uint32_t length, bool stream) {
  Stream out = {0xA5, 0x5A, 0, 0, 0, 0, static_cast<std::uint8_t>(response)};
  store_le(length | (stream ? 1U << 30 : 0U), &out[2]);
  return out;
}

inline Stream node(int angle_q6, int distance_q2, int quality = 15, bool start = false) {
  return {static_cast<std::uint8_t>(quality << 2 | (start ? 1 : 2)),
          static_cast<std::uint8_t>((angle_q6 & 0x7F) << 1 | 1),
          static_cast<std::uint8_t>(angle_q6 >> 7), static_cast<std::uint8_t>(distance_q2),
          static_cast<std::uint8_t>(distance_q2 >> 8)};
}

/// Head and checksum around a capsule's contents.
inline Stream capsule(int start_q6, const Stream& contents, bool first = false) {
  Stream out = {0, 0, static_cast<std::uint8_t>(start_q6),
                static_cast<std::uint8_t>(start_q6 >> 8 | (first ? 0x80 : 0))};
  out.insert(out.end(), contents.begin(), contents.end());
  unsigned sum = 0;
  for (const std::uint8_t byte : out) sum ^= byte;
  out[0] = static_cast<std::uint8_t>(0xA0 | (sum & 0xF));
  out[1] = static_cast<std::uint8_t>(0x50 | sum >> 4);
  return out;
}

inline Points points_of(const Stream& stream, RplidarResponse inside = RplidarResponse::none) {
  RplidarDecoder decoder{RplidarFraming(inside)};
  RplidarUnpacker unpacker;
  Points points;
  const auto sink = [&](const RplidarPacket& packet) {
    unpacker.add(packet, [&](std::span<const RplidarPoint> some) {
      points.insert(points.end(), some.begin(), some.end());
    });
  };
  decoder.feed(stream, sink);
  decoder.finish(sink);
  return points;
}

}  // namespace wayfare::decode
