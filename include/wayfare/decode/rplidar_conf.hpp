#pragma once

// Settings of a SLAMTEC RPLIDAR (GET_LIDAR_CONF and SET_LIDAR_CONF, firmware 1.24 and later), and
// the request of HQ capsules. Layouts: SLAMTEC, sl_lidar_cmd.h of SDK 2.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/time.hpp>
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

/// Queries a setting; the response is RplidarConf.
constexpr RplidarRequest rplidar_get_conf(RplidarConfKey key) {
  const auto k = static_cast<std::uint32_t>(key);
  return detail::rplidar_request(0x84, {k, k >> 8, k >> 16, k >> 24});
}
/// Queries a setting of one scan mode.
constexpr RplidarRequest rplidar_get_conf(RplidarConfKey key, std::uint16_t mode) {
  const auto k = static_cast<std::uint32_t>(key);
  return detail::rplidar_request(
      0x84, {k, k >> 8, k >> 16, k >> 24, mode, static_cast<unsigned>(mode >> 8)});
}

/// Changes a setting; the response is RplidarConfSet. `value` in the device's form, at most 56
/// bytes; nullopt where it is longer.
[[nodiscard]] inline std::optional<RplidarRequest> rplidar_set_conf(RplidarConfKey key,
                                                                    Bytes value) {
  std::array<std::uint8_t, 4 + 56> payload{};
  if (value.size() > payload.size() - 4) return std::nullopt;
  store_le(static_cast<std::uint32_t>(key), payload.data());
  std::copy(value.begin(), value.end(), payload.begin() + 4);
  return detail::rplidar_request(0x85, Bytes(payload).first(4 + value.size()));
}

/// Starts a scan of HQ capsules: one flag byte and 32 reserved ones.
constexpr RplidarRequest rplidar_hq_scan(std::uint8_t flag = 0) {
  return detail::rplidar_request(0x83, std::array<std::uint8_t, 33>{flag});
}

/// Response to rplidar_get_conf; the value's meaning depends on the key.
struct RplidarConf {
  RplidarConfKey key{};  ///< as queried
  Bytes value;           ///< as sent; must outlive this
};

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

/// The content of a response of 4 bytes or more.
[[nodiscard]] inline std::optional<RplidarConf> rplidar_conf(Bytes b) {
  if (b.size() < 4) return std::nullopt;
  return RplidarConf{static_cast<RplidarConfKey>(load_le<std::uint32_t>(b.data())), b.subspan(4)};
}

/// The time of one sample of a mode, where `conf` is that: more than none, less than a second.
[[nodiscard]] inline std::optional<Duration> rplidar_mode_sample(const RplidarConf& conf) {
  if (conf.key != RplidarConfKey::mode_sample_us || conf.value.size() < 4) return std::nullopt;
  const auto us_q8 = load_le<std::uint32_t>(conf.value.data());
  if (us_q8 == 0 || us_q8 >= 256'000'000U) return std::nullopt;
  return Duration(std::int64_t{us_q8} * 1000 / 256);
}

}  // namespace wayfare::decode
