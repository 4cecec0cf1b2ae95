#pragma once

// A packet of an RPLIDAR, and the check bits of nodes and capsules.

#include <cstddef>
#include <cstdint>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>

namespace wayfare::decode {

/// A checked packet. It refers to the decoder's bytes.
class RplidarPacket {
 public:
  RplidarPacket() = default;
  RplidarPacket(RplidarResponse response, bool descriptor, std::uint64_t position, Bytes bytes)
      : response_(response), descriptor_(descriptor), position_(position), bytes_(bytes) {}

  /// The type of the packet; of a descriptor, the type it announces.
  [[nodiscard]] RplidarResponse response() const { return response_; }
  [[nodiscard]] bool is_descriptor() const { return descriptor_; }
  [[nodiscard]] std::uint64_t position() const { return position_; }
  [[nodiscard]] Bytes bytes() const { return bytes_; }

 private:
  RplidarResponse response_ = RplidarResponse::none;
  bool descriptor_ = false;
  std::uint64_t position_ = 0;
  Bytes bytes_;
};

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

}  // namespace wayfare::decode
