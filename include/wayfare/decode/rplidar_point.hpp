#pragma once

// One measurement of a SLAMTEC RPLIDAR.

#include <cstdint>

#include <wayfare/core/detail/bytes.hpp>

namespace wayfare::decode {

/// One measurement. Angles grow clockwise seen from above.
struct RplidarPoint {
  std::uint16_t angle_q6 = 0;     ///< 1/64°, below 360°
  std::uint32_t distance_q2 = 0;  ///< 1/4 mm; 0: no return
  /// Of the echo: 0 to 63 in nodes, 0 to 255 in HQ and ultra-dense capsules; other capsules have
  /// none, their returns are 47.
  std::uint8_t quality = 0;
  bool start_of_revolution = false;  ///< first of it
  std::uint8_t angle_rest_q13 = 0;   ///< 1/8192°, below 128: the rest of an HQ angle

  /// Clockwise, degrees.
  [[nodiscard]] double angle_deg() const { return angle_q6 / 64.0 + angle_rest_q13 / 8192.0; }
  [[nodiscard]] double distance_m() const { return distance_q2 / 4000.0; }  ///< 0: no return
  /// In the unit of newer devices and the maker's library: 90° are 2^14.
  [[nodiscard]] std::uint16_t angle_z_q14() const {
    return static_cast<std::uint16_t>((std::uint32_t{angle_q6} << 7 | angle_rest_q13) / 45U);
  }
  bool operator==(const RplidarPoint&) const = default;  ///< of all values
};

/// The point of a node: five bytes that satisfy `is_rplidar_node`.
[[nodiscard]] inline RplidarPoint rplidar_node(Bytes b) {
  return {static_cast<std::uint16_t>(b[1] >> 1 | b[2] << 7), load_le<std::uint16_t>(&b[3]),
          static_cast<std::uint8_t>(b[0] >> 2), (b[0] & 1) != 0};
}

}  // namespace wayfare::decode
