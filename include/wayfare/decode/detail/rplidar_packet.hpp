#pragma once

// A packet of an RPLIDAR, and the marks by which nodes and capsules are known.

#include <cstddef>
#include <cstdint>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>

namespace wayfare::decode {

/// A checked packet. It refers to the decoder's bytes.
class RplidarPacket {
 public:
  RplidarPacket() = default;
  RplidarPacket(RplidarAnswer answer, bool descriptor, std::uint64_t position, Bytes bytes)
      : answer_(answer), descriptor_(descriptor), position_(position), bytes_(bytes) {}

  /// What it is, or, of a descriptor, what it announces.
  [[nodiscard]] RplidarAnswer answer() const { return answer_; }
  [[nodiscard]] bool is_descriptor() const { return descriptor_; }
  [[nodiscard]] std::uint64_t position() const { return position_; }
  [[nodiscard]] Bytes bytes() const { return bytes_; }

 private:
  RplidarAnswer answer_ = RplidarAnswer::none;
  bool descriptor_ = false;
  std::uint64_t position_ = 0;
  Bytes bytes_;
};

/// Whether five bytes may be a node: start bit and its inverse, check bit, angle below 360°.
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

/// Angle of five bytes that may be a node, 1/64°.
[[nodiscard]] inline int rplidar_node_angle(const std::uint8_t* p) { return p[1] >> 1 | p[2] << 7; }

/// Whether two angles may be those of neighbours: less than 10° apart, either way round.
[[nodiscard]] inline bool rplidar_follows(int angle, int last) {
  constexpr int kTurn = 360 * 64, kLargestStep = 10 * 64;
  const int step = (angle - last + kTurn + kTurn / 2) % kTurn - kTurn / 2;
  return step > -kLargestStep && step < kLargestStep;
}

/// How many nodes from `at` on follow each other; no more than this many are looked at.
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
