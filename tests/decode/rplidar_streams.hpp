#pragma once

// RPLIDAR byte streams built by the manual, and their decoded messages.

#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_point.hpp>
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

/// XOR of a capsule's bytes behind its head, in its two sync bytes.
inline void seal_capsule(Stream& out) {
  unsigned sum = 0;
  for (std::size_t i = 2; i < out.size(); ++i) sum ^= out[i];
  out[0] = static_cast<std::uint8_t>(0xA0 | (sum & 0xF));
  out[1] = static_cast<std::uint8_t>(0x50 | sum >> 4);
}

/// The 20 bits of an ultra-dense measurement: a distance of the first 12 to 15 bits, quality above.
inline std::uint32_t ultra_dense_code(int scale, unsigned units, unsigned quality) {
  return static_cast<std::uint32_t>(scale) | units << 2 | quality << (12 + scale);
}

/// A capsule of 64 measurements, two in five bytes.
inline Stream ultra_dense_capsule(int start_q6, const std::vector<std::uint32_t>& codes,
                                  bool first = false) {
  Stream out(170);
  store_le(std::uint32_t{123456}, &out[2]);
  store_le(static_cast<std::uint16_t>(start_q6 | (first ? 0x8000 : 0)), &out[8]);
  for (std::size_t i = 0; i < 64; ++i) {
    std::uint8_t* cabin = &out[10 + 5 * (i / 2)];
    store_le(static_cast<std::uint16_t>(codes[i]), cabin + 2 * (i % 2));
    cabin[4] |= static_cast<std::uint8_t>((codes[i] >> 16 & 0xFU) << (i % 2 == 0 ? 0 : 4));
  }
  seal_capsule(out);
  return out;
}

/// A measurement of an HQ capsule.
struct HqNode {
  std::uint16_t angle_z_q14 = 0;
  std::uint32_t distance_q2 = 0;
  std::uint8_t quality = 0, flag = 2;
};

/// CRC-32 bit by bit, of the bytes and zeros up to a multiple of four.
inline std::uint32_t plain_crc32(Stream bytes) {
  while (bytes.size() % 4 != 0) bytes.push_back(0);
  std::uint32_t sum = 0xFFFFFFFF;
  for (const std::uint8_t byte : bytes) {
    sum ^= byte;
    for (int bit = 0; bit < 8; ++bit) sum = sum >> 1 ^ ((sum & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~sum;
}

/// A capsule of 96 measurements with a time, closed by a CRC-32.
inline Stream hq_capsule(const std::vector<HqNode>& nodes, std::uint64_t time = 1) {
  Stream out(777);
  out[0] = 0xA5;
  store_le(time, &out[1]);
  for (std::size_t i = 0; i < 96; ++i) {
    std::uint8_t* p = &out[9 + 8 * i];
    store_le(nodes[i].angle_z_q14, p);
    store_le(nodes[i].distance_q2, p + 2);
    p[6] = nodes[i].quality;
    p[7] = nodes[i].flag;
  }
  const std::uint32_t sum = plain_crc32(out);
  out.resize(781);
  store_le(sum, &out[777]);
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
