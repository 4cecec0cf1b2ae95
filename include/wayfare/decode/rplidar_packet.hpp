#pragma once

// Packets of a SLAMTEC RPLIDAR, and how nodes and capsules are recognised among bytes.

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/detail/crc32.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>

namespace wayfare::decode {

/// A checked packet. It refers to the decoder's bytes.
class RplidarPacket {
 public:
  RplidarPacket() = default;
  /// Of a checked packet; `position`: of its first byte in the stream.
  RplidarPacket(RplidarResponse response, bool descriptor, std::uint64_t position, Bytes bytes)
      : response_(response), descriptor_(descriptor), position_(position), bytes_(bytes) {}

  /// The type of the packet; of a descriptor, the type it announces.
  [[nodiscard]] RplidarResponse response() const { return response_; }
  /// Whether it announces what follows.
  [[nodiscard]] bool is_descriptor() const { return descriptor_; }
  /// Of its first byte in the stream.
  [[nodiscard]] std::uint64_t position() const { return position_; }
  /// All of it.
  [[nodiscard]] Bytes bytes() const { return bytes_; }

 private:
  RplidarResponse response_ = RplidarResponse::none;
  bool descriptor_ = false;
  std::uint64_t position_ = 0;
  Bytes bytes_;
};

/// Whether a response is an endless sequence of nodes or capsules.
[[nodiscard]] constexpr bool is_rplidar_scan(RplidarResponse response) {
  return rplidar_packet_bytes(response) != 0;
}

/// Whether five bytes are a possible node: start bit and its inverse, check bit, angle below 360°.
[[nodiscard]] inline bool is_rplidar_node(const std::uint8_t* p) {
  return ((p[0] ^ p[0] >> 1) & 1) != 0 && (p[1] & 1) != 0 && (p[1] >> 1 | p[2] << 7) < 360 * 64;
}

/// Whether a whole capsule begins with its sync nibbles and the XOR of what follows.
[[nodiscard]] inline bool is_rplidar_capsule(Bytes b) {
  unsigned sum = 0;
  for (const std::uint8_t byte : b.subspan(2)) sum ^= byte;
  return b[0] >> 4 == 0xA && b[1] >> 4 == 0x5 &&
         sum == static_cast<unsigned>((b[0] & 0xF) | (b[1] & 0xF) << 4);
}

/// Whether a whole HQ capsule begins with its sync byte and ends with the CRC-32 of what precedes,
/// filled up to whole words.
[[nodiscard]] inline bool is_rplidar_hq_capsule(Bytes b) {
  constexpr std::size_t kChecked = rplidar_packet_bytes(RplidarResponse::hq) - 4;
  constexpr std::array<std::uint8_t, 3> kFill{};
  const std::uint32_t sum = detail::crc32(kFill, detail::crc32(b.first(kChecked)));
  return b[0] == 0xA5 && sum == load_le<std::uint32_t>(&b[kChecked]);
}

/// Angle of a possible node, 1/64°.
[[nodiscard]] inline int rplidar_node_angle(const std::uint8_t* p) { return p[1] >> 1 | p[2] << 7; }

/// Whether two angles can be those of consecutive nodes: less than 10° apart in either direction.
[[nodiscard]] inline bool rplidar_follows(int angle, int last) {
  constexpr int kFullCircle = 360 * 64, kLargestStep = 10 * 64;
  const int step = (angle - last + kFullCircle + kFullCircle / 2) % kFullCircle - kFullCircle / 2;
  return step > -kLargestStep && step < kLargestStep;
}

/// Number of consecutive nodes from `at` on, up to this limit.
inline constexpr std::size_t kRplidarChain = 12;
/// Number of consecutive nodes that begin at byte `at`, at most kRplidarChain.
[[nodiscard]] inline std::size_t rplidar_chain(Bytes b, std::size_t at) {
  std::size_t n = 0;
  for (int last = -1; n < kRplidarChain && at + 5 <= b.size() && is_rplidar_node(&b[at]); at += 5) {
    const int angle = rplidar_node_angle(&b[at]);
    if (last >= 0 && !rplidar_follows(angle, last)) break;
    last = angle;
    ++n;
  }
  return n;
}

/// Whether these bytes are twelve nodes of a laser that turns: a repeated byte may be a node, too.
[[nodiscard]] inline bool is_rplidar_run(Bytes b) {
  constexpr int kLeast_q6 = 32;  // half a degree in twelve nodes
  if (rplidar_chain(b, 0) != kRplidarChain) return false;
  const int angle = rplidar_node_angle(&b[5 * (kRplidarChain - 1)]) - rplidar_node_angle(b.data());
  return (angle + 360 * 64) % (360 * 64) >= kLeast_q6;
}

/// Bytes of a capsule up to the end of its first angle.
[[nodiscard]] constexpr std::size_t rplidar_capsule_head(RplidarResponse response) {
  return response == RplidarResponse::ultra_dense ? 10 : 4;
}

/// Whether these bytes are a whole capsule and the head of the one that follows.
[[nodiscard]] inline bool is_rplidar_capsule_run(Bytes b, RplidarResponse response) {
  const std::size_t size = rplidar_packet_bytes(response);
  const auto angle = [at = rplidar_capsule_head(response) - 2](const std::uint8_t* capsule) {
    return static_cast<int>(load_le<std::uint16_t>(capsule + at) & 0x7FFFU);
  };
  const std::uint8_t* next = b.data() + size;
  const int step = (angle(next) - angle(b.data()) + 360 * 64) % (360 * 64);
  return is_rplidar_capsule(b.first(size)) && next[0] >> 4 == 0xA && next[1] >> 4 == 0x5 &&
         angle(b.data()) < 360 * 64 && angle(next) < 360 * 64 && step > 0 && step < 90 * 64;
}

/// Whether the 84 bytes of a capsule are a dense one's: read so, more of its consecutive distances
/// are within a twentieth of each other than where it is read as an express one.
[[nodiscard]] inline bool is_rplidar_dense(Bytes b) {
  const auto near = [last = 0](int distance) mutable {
    const int before = std::exchange(last, distance);
    return before != 0 && distance != 0 && std::abs(distance - before) * 20 <= before ? 1 : 0;
  };
  auto near_dense = near, near_express = near;
  int dense = 0, express = 0;
  for (std::size_t i = 4; i < 84; i += 2) dense += near_dense(load_le<std::uint16_t>(&b[i]));
  for (std::size_t i = 4; i < 84; i += 5)
    for (const std::size_t at : {i, i + 2})
      express += near_express(load_le<std::uint16_t>(&b[at]) >> 2);
  return dense * 31 > express * 39;  // of 39 and of 31 steps
}

}  // namespace wayfare::decode
