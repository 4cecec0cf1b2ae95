#pragma once

// Settings of a SLAMTEC RPLIDAR (GET_LIDAR_CONF and SET_LIDAR_CONF, firmware 1.24 and later), and
// the request of HQ capsules. Layouts: SLAMTEC, sl_lidar_cmd.h of SDK 2.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>

namespace wayfare::decode {

/// Keys of settings. Those marked "per mode" are queried with the number of a scan mode.
enum class RplidarConfKey : std::uint32_t {
  angle_range = 0x00,           ///< limits of the angles
  desired_rotation = 0x01,      ///< u16 1/min, u16 duty cycle of the motor
  scan_commands = 0x02,         ///< bits of the supported scan requests
  least_rotation = 0x04,        ///< lowest speed of the motor
  most_rotation = 0x05,         ///< highest speed of the motor
  max_distance = 0x60,          ///< of any mode
  mode_count = 0x70,            ///< u16
  mode_sample_us = 0x71,        ///< per mode: u32, 1/256 µs
  mode_max_distance = 0x74,     ///< per mode: u32, 1/256 m
  mode_response = 0x75,         ///< per mode: u8, an RplidarResponse
  mac_address = 0x79,           ///< six bytes
  typical_mode = 0x7C,          ///< u16
  mode_name = 0x7F,             ///< per mode: text
  model_revision = 0x80,        ///< u16
  model_name = 0x81,            ///< text
  detected_baud = 0xA1,         ///< u32 bit/s
  static_ip_address = 0x1CCC0,  ///< addresses of the network interface
};

/// Changes a setting; the response is RplidarConfSet. `value` in the device's form, at most 56
/// bytes; nullopt where it is longer.
[[nodiscard]] inline std::optional<RplidarRequest> rplidar_set_conf(RplidarConfKey key,
                                                                    Bytes value) {
  RplidarRequest request;
  constexpr std::size_t kAround = 2 + 1 + 4 + 1;  // command, length, key, sum
  if (value.size() > request.content.size() - kAround) return std::nullopt;
  request.content[0] = 0xA5;
  request.content[1] = 0x85;
  request.content[2] = static_cast<std::uint8_t>(4 + value.size());
  store_le(static_cast<std::uint32_t>(key), &request.content[3]);
  std::copy(value.begin(), value.end(), request.content.begin() + 7);
  request.size = kAround + value.size();
  std::uint8_t sum = 0;
  for (std::size_t i = 0; i + 1 < request.size; ++i) sum ^= request.content[i];
  request.content[request.size - 1] = sum;
  return request;
}

/// Starts a scan of HQ capsules: one flag byte and 32 reserved ones.
constexpr RplidarRequest rplidar_hq_scan(std::uint8_t flag = 0) {
  RplidarRequest request;
  request.content[0] = 0xA5;
  request.content[1] = 0x83;
  request.content[2] = 33;
  request.content[3] = flag;
  request.size = 2 + 1 + 33 + 1;
  request.content[request.size - 1] = static_cast<std::uint8_t>(0xA5 ^ 0x83 ^ 33 ^ flag);
  return request;
}

/// Response to rplidar_set_conf.
struct RplidarConfSet {
  RplidarConfKey key{};      ///< of the setting
  std::uint32_t result = 0;  ///< 0: changed, else the device's error code
};

/// The content of a response of 8 bytes.
[[nodiscard]] inline std::optional<RplidarConfSet> rplidar_conf_set(Bytes b) {
  if (b.size() != 8) return std::nullopt;
  return RplidarConfSet{static_cast<RplidarConfKey>(load_le<std::uint32_t>(b.data())),
                        load_le<std::uint32_t>(&b[4])};
}

}  // namespace wayfare::decode
