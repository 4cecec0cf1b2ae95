#pragma once

// The arithmetic of an RPLIDAR's capsules.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/rplidar_point.hpp>

namespace wayfare::decode::detail {

/// Angles of a capsule's points: evenly spaced from its start to the next one's.
struct CapsuleAngles {
  static constexpr int kTurn_q6 = 360 * 64, kTurn_q16 = 360 << 16;
  int angle_q16 = 0, step_q16 = 0;

  CapsuleAngles(int start_q6, int next_q6, int points) : angle_q16(start_q6 % kTurn_q6 << 10) {
    const int span_q6 = next_q6 % kTurn_q6 - start_q6 % kTurn_q6;
    step_q16 = ((span_q6 + (span_q6 < 0 ? kTurn_q6 : 0)) << 10) / points;
  }
  /// The next point, `offset_q16` before its nominal angle. Written in place: copying a returned
  /// one in wide loads would wait for its narrow stores (no store forwarding).
  void next(RplidarPoint& point, std::uint32_t distance_q2, int offset_q16) {
    int q16 = angle_q16 - offset_q16;
    q16 += q16 < 0 ? kTurn_q16 : 0;
    q16 -= q16 >= kTurn_q16 ? kTurn_q16 : 0;
    angle_q16 += step_q16;
    const bool start = angle_q16 >= kTurn_q16;
    angle_q16 -= start ? kTurn_q16 : 0;
    constexpr std::uint8_t kNoQuality = 0x2F;
    point.angle_q6 = static_cast<std::uint16_t>(q16 >> 10);
    point.distance_q2 = distance_q2;
    point.quality = distance_q2 != 0 ? kNoQuality : std::uint8_t{0};
    point.start_of_revolution = start;
  }
};

/// A distance of the ultra capsule: the resolution decreases with distance.
struct VariableScale {
  int value = 0, level = 0;

  explicit VariableScale(int code) {
    constexpr std::array<std::array<int, 3>, 5> kScales = {
        {{3328, 1 << 14, 4}, {1792, 1 << 12, 3}, {1280, 1 << 11, 2}, {512, 1 << 9, 1}, {0, 0, 0}}};
    for (const auto& [from, base, bits] : kScales) {
      if (code < from) continue;
      level = bits;
      value = base + ((code - from) << bits);
      return;
    }
  }
};

/// Angle error of near points due to the beam's offset from the axis (ultra), degrees · 2^16.
[[nodiscard]] inline int ultra_offset_q16(std::uint32_t distance_q2) {
  constexpr double kPi = 3.1415926535;
  int radians_q16 = static_cast<int>(7.5 * kPi * (1 << 16) / 180.0);
  if (distance_q2 >= 50 * 4) {
    const int k = static_cast<int>(98361U / distance_q2);
    radians_q16 = static_cast<int>(8.0 * kPi * (1 << 16) / 180.0) - (k << 6) - k * k * k / 98304;
  }
  return static_cast<int>(radians_q16 * 180 / 3.14159265);
}

/// A measurement of the HQ capsule: angle (90° are 2^14), distance, quality, flags. Its angle is
/// kept exactly: 2^16 of its units are 23 040 · 128 of angle_rest_q13.
inline void hq_point(const std::uint8_t* p, RplidarPoint& point) {
  const std::uint32_t fine = load_le<std::uint16_t>(p) * 45U;
  point.angle_q6 = static_cast<std::uint16_t>(fine >> 7);
  point.angle_rest_q13 = static_cast<std::uint8_t>(fine & 0x7FU);
  point.distance_q2 = load_le<std::uint32_t>(p + 2);
  point.quality = p[6];
  point.start_of_revolution = (p[7] & 1) != 0;
}

/// The measurements of ultra-dense capsules: 20 bits for each, of which the lowest two say how many
/// are the distance and how coarse it is. Distances near the one before are averaged with it.
class UltraDensePoints {
 public:
  /// 64 points of `capsule`, which begins at `start_q6` and the next at `next_q6`.
  [[gnu::noinline]] void unpack(const std::uint8_t* capsule, int start_q6, int next_q6,
                                RplidarPoint* points) {
    constexpr int kTurn_q16 = 360 << 16, kTurn_q6 = 360 << 6;
    const int span_q6 = next_q6 - start_q6 + (next_q6 < start_q6 ? kTurn_q6 : 0);
    const int step_q16 = (span_q6 << 10) / 64;
    int angle_q16 = start_q6 << 10;
    for (std::size_t i = 0; i < 64; ++i, ++points) {
      const std::uint8_t* cabin = capsule + 10 + 5 * (i / 2);
      const unsigned high = i % 2 == 0 ? cabin[4] & 0xFU : cabin[4] >> 4U;
      take(load_le<std::uint16_t>(cabin + 2 * (i % 2)) | high << 16, *points);
      const int angle_q6 = angle_q16 >> 10;
      points->angle_q6 =
          static_cast<std::uint16_t>(angle_q6 - (angle_q6 < kTurn_q6 ? 0 : kTurn_q6));
      angle_q16 += step_q16;
      // Up to two points pass this test; the first begins the revolution.
      const bool near_start = angle_q16 % kTurn_q16 < step_q16 * 2;
      points->start_of_revolution = near_start && !started_;
      started_ = points->start_of_revolution;
    }
  }

 private:
  void take(std::uint32_t code, RplidarPoint& point) {
    struct Scale {
      unsigned mask, bits, factor, offset_mm;
    };
    // Each continues where the finer one before it ends.
    constexpr std::array<Scale, 4> kScales = {
        {{0xFFC, 12, 2, 0}, {0x1FFC, 13, 3, 2046}, {0x3FFC, 14, 4, 8187}, {0x7FFC, 15, 5, 24567}}};
    const Scale& scale = kScales[code & 3U];
    auto distance_q2 =
        static_cast<int>((code & scale.mask) * scale.factor + (scale.offset_mm << 2));
    if ((code & 3U) == 0 && last_q2_ != 0 && std::abs(distance_q2 - last_q2_) <= 8)
      distance_q2 = (distance_q2 + last_q2_) >> 1;
    last_q2_ = distance_q2;
    point.distance_q2 = static_cast<std::uint32_t>(distance_q2);
    point.quality = static_cast<std::uint8_t>(code >> scale.bits << (code & 3U));
  }

  int last_q2_ = 0;       ///< distance before
  bool started_ = false;  ///< the point before began a revolution
};

}  // namespace wayfare::decode::detail
