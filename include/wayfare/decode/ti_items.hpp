#pragma once

// Profiles and heat maps of a TI mmWave sensor's frame, typed. They refer to the frame's bytes.

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/ti_frame.hpp>

namespace wayfare::decode {

/// Numbers of one type, little endian.
template <class T>
class TiNumbers {
 public:
  TiNumbers() = default;
  /// What exceeds a whole number of them is left out.
  explicit TiNumbers(Bytes payload) : payload_(payload) {}

  [[nodiscard]] std::size_t size() const { return payload_.size() / sizeof(T); }  ///< how many
  /// Number i < size().
  [[nodiscard]] T operator[](std::size_t i) const { return load_le<T>(&payload_[sizeof(T) * i]); }

 private:
  Bytes payload_;
};

/// A level in a profile or map of SDK 3: 1/512 of a factor of two in magnitude, as dB.
[[nodiscard]] inline double ti_level_db(std::uint16_t level) {
  constexpr double kPerDoubling = 6.020599913279624;  // 20 log10(2)
  return level * kPerDoubling / 512.0;
}

/// For each range bin the level at rest (item 2); empty without it.
[[nodiscard]] inline TiNumbers<std::uint16_t> ti_range_profile(const TiFrame& frame) {
  return TiNumbers<std::uint16_t>(frame.find(TiTlv::range_profile));
}
/// For each range bin the level at the largest speed, which is noise (item 3).
[[nodiscard]] inline TiNumbers<std::uint16_t> ti_noise_profile(const TiFrame& frame) {
  return TiNumbers<std::uint16_t>(frame.find(TiTlv::noise_profile));
}
/// The level in each Doppler bin of each range bin, range by range (item 5).
[[nodiscard]] inline TiNumbers<std::uint16_t> ti_range_doppler_map(const TiFrame& frame) {
  return TiNumbers<std::uint16_t>(frame.find(TiTlv::range_doppler_map));
}
/// The signal at rest of each virtual antenna in each range bin, range by range: imaginary part,
/// then real part (item 4, or with the elevation's antennas item 8).
[[nodiscard]] inline TiNumbers<std::int16_t> ti_azimuth_map(const TiFrame& frame) {
  const Bytes azimuth = frame.find(TiTlv::azimuth_heat_map);
  return TiNumbers<std::int16_t>(azimuth.empty() ? frame.find(TiTlv::elevation_heat_map) : azimuth);
}
/// Range profile of an xWRL sensor (items 302, 303), in the device's unit.
[[nodiscard]] inline TiNumbers<std::uint32_t> ti_linear_profile(const TiFrame& frame) {
  const Bytes major = frame.find(TiTlv::range_profile_major);
  return TiNumbers<std::uint32_t>(major.empty() ? frame.find(TiTlv::range_profile_minor) : major);
}

}  // namespace wayfare::decode
