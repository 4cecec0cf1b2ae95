#pragma once

// The headers of a TI mmWave sensor's frames, and the types of the items behind them.

#include <cstddef>
#include <cstdint>

namespace wayfare::decode {

/// The header in front of a frame's items.
enum class TiLayout : std::uint8_t {
  demo,          ///< 40 bytes; 36 of xWR14xx and the first SDK
  area_scanner,  ///< 44 bytes: as of the demo, then the number of static points
  tracker_3d,    ///< 48 bytes with a checksum: 3D people counting
  tracker_2d,    ///< 52 bytes with a checksum: people counting in a plane
};

/// The header of a frame, without its magic word.
struct TiHeader {
  std::uint32_t version = 0;       ///< major << 24 | minor << 16 | bugfix << 8 | build
  std::uint32_t total_bytes = 0;   ///< from the magic word to the end of the padding
  std::uint32_t platform = 0;      ///< 0xA1843, 0xA1642, 0xA1443, 0xA6843 …
  std::uint32_t frame_number = 0;  ///< from 1 after a reset
  /// A counter of `ti_clock_hz`, when the frame was built; 0 where `has_clock` is false.
  std::uint32_t cycles = 0;
  std::uint32_t points = 0;          ///< detected objects
  std::uint32_t tlvs = 0;            ///< items that follow
  std::uint32_t subframe = 0;        ///< index, from 0; 0 without subframes
  TiLayout layout = TiLayout::demo;  ///< which header it is
  std::uint32_t static_points = 0;   ///< of an area scanner

  /// First number of the version.
  [[nodiscard]] std::uint32_t major() const { return version >> 24; }
  /// Whether the header has the counter.
  [[nodiscard]] bool has_clock() const { return layout != TiLayout::tracker_3d; }
  /// Whether the lengths of items include the eight bytes of their type and length.
  [[nodiscard]] bool counts_item_heads() const {
    return layout == TiLayout::tracker_3d || layout == TiLayout::tracker_2d;
  }
  /// Of the header; xWR14xx and the first SDK have no subframe number.
  [[nodiscard]] std::size_t bytes() const {
    if (layout != TiLayout::demo) return 40 + 4 * static_cast<std::size_t>(layout);
    return version <= 0x01000005U || (platform & 0xFFFFU) == 0x1443U ? 36 : 40;
  }
};

/// Rate of `TiHeader::cycles`: the R4F core at 200 MHz in SDK 3, the DSP at 600 MHz before and in
/// people counting in a plane.
[[nodiscard]] inline double ti_clock_hz(const TiHeader& header) {
  return header.major() >= 3 && header.layout != TiLayout::tracker_2d ? 200e6 : 600e6;
}

/// Types of items. Those up to 9 are of the demo: other layouts use these numbers for other
/// content, which TiFrame and `ti_tracking.hpp` provide.
enum class TiTlv : std::uint32_t {
  points = 1,                 ///< detected objects
  range_profile = 2,          ///< u16 log2 magnitude (Q9 in SDK 3) for each range bin
  noise_profile = 3,          ///< the same at the largest Doppler
  azimuth_heat_map = 4,       ///< i16 (imaginary, real) for each range bin and virtual antenna
  range_doppler_map = 5,      ///< u16 for each range bin and Doppler bin
  statistics = 6,             ///< TiStatistics
  side_info = 7,              ///< strength and noise of each point
  elevation_heat_map = 8,     ///< as 4, with all virtual antennas
  temperature = 9,            ///< TiTemperature
  packed_points = 301,        ///< xWRL: points in common units, with strength and noise
  range_profile_major = 302,  ///< xWRL: u32 for each range bin
  range_profile_minor = 303,  ///< xWRL: the same of the second set of frames
  heat_map_major = 304,       ///< xWRL: u32 for each range bin and azimuth
  heat_map_minor = 305,       ///< xWRL: the same of the second set of frames
  packed_statistics = 306,  ///< xWRL: u32 µs of processing and sending, then powers, temperatures
  packed_targets = 308,     ///< xWRL: as 1010
  packed_target_index = 309,  ///< xWRL: as 1011
  zone_presence = 315,        ///< xWRL: u8 number of zones, two bits for each
  spherical_points = 1000,    ///< range, azimuth, elevation, speed as floats
  targets = 1010,             ///< TiTarget
  target_index = 1011,        ///< u8 for each point of the frame before: its target
  target_heights = 1012,      ///< TiTargetHeight
  compressed_points = 1020,   ///< spherical, in common units, with strength
  presence = 1021,            ///< u32: whether anyone is in the zone
  occupancy = 1030,           ///< u32: a bit for each zone
  vital_signs = 1040,         ///< TiVitalSigns
};

}  // namespace wayfare::decode
