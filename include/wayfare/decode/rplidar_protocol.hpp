#pragma once

// Requests to a SLAMTEC RPLIDAR and its single responses (SLAMTEC, RPLIDAR Interface Protocol and
// Application Notes, rev. 2.2). Little endian.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>

#include <wayfare/core/detail/bytes.hpp>

namespace wayfare::decode {

/// Bytes to send, all within five seconds.
struct RplidarRequest {
  std::array<std::uint8_t, 64> content{};  ///< the first `size` are sent
  std::size_t size = 0;                    ///< bytes

  /// What to send.
  [[nodiscard]] Bytes bytes() const { return Bytes(content).first(size); }
};

namespace detail {

/// A5, command, and with a payload: its length, the payload and the XOR of all bytes before.
template <class Numbers = std::initializer_list<unsigned>>
constexpr RplidarRequest rplidar_request(std::uint8_t command, const Numbers& payload = {}) {
  RplidarRequest request;
  const auto put = [&](unsigned byte) {
    request.content[request.size++] = static_cast<std::uint8_t>(byte);
  };
  put(0xA5);
  put(command);
  if (payload.size() == 0) return request;
  put(static_cast<unsigned>(payload.size()));
  for (const auto byte : payload) put(byte & 0xFFU);
  unsigned sum = 0;
  for (std::size_t i = 0; i < request.size; ++i) sum ^= request.content[i];
  put(sum);
  return request;
}

}  // namespace detail

/// Ends a scan; no response. Wait 20 ms: data already sent still arrives.
constexpr RplidarRequest rplidar_stop() { return detail::rplidar_request(0x25); }
/// Restarts the device, which prints a text; no response. Wait half a second.
constexpr RplidarRequest rplidar_reset() { return detail::rplidar_request(0x40); }
/// Starts a scan of single nodes; `force`: without waiting for a steady rotation.
constexpr RplidarRequest rplidar_scan(bool force = false) {
  return detail::rplidar_request(force ? 0x21 : 0x20);
}
/// Starts a scan of capsules. Mode 0 is the oldest; the others are queried with rplidar_get_conf.
constexpr RplidarRequest rplidar_express_scan(std::uint8_t mode = 0) {
  return detail::rplidar_request(0x82, {mode, 0, 0, 0, 0});
}
/// Queries model, firmware and serial number.
constexpr RplidarRequest rplidar_get_info() { return detail::rplidar_request(0x50); }
/// Queries the state.
constexpr RplidarRequest rplidar_get_health() { return detail::rplidar_request(0x52); }
/// Queries the times of one sample.
constexpr RplidarRequest rplidar_get_sample_rate() { return detail::rplidar_request(0x59); }
/// Queries the features of the adapter board: bit 0, it controls the motor.
constexpr RplidarRequest rplidar_get_board_flags() {
  return detail::rplidar_request(0xFF, {0, 0, 0, 0});
}
/// A2, A3: speed of the motor as duty cycle, 0 (off) to 1023. The A1's motor is on while DTR is
/// off.
constexpr RplidarRequest rplidar_motor_pwm(std::uint16_t duty) {
  return detail::rplidar_request(0xF0, {duty, static_cast<unsigned>(duty >> 8)});
}
/// S series: speed of the motor in revolutions per minute, 0 for off.
constexpr RplidarRequest rplidar_motor_speed(std::uint16_t rpm) {
  return detail::rplidar_request(0xA8, {rpm, static_cast<unsigned>(rpm >> 8)});
}

/// The type of a response, from its descriptor.
enum class RplidarResponse : std::uint8_t {
  none = 0,            ///< no response
  info = 0x04,         ///< RplidarInfo
  health = 0x06,       ///< RplidarHealth
  sample_rate = 0x15,  ///< RplidarSampleRate
  conf = 0x20,         ///< RplidarConf
  conf_set = 0x21,     ///< a setting was changed
  node = 0x81,         ///< one measurement
  express = 0x82,      ///< capsule of 32 measurements
  hq = 0x83,           ///< capsule of 96 measurements with quality, and a time
  ultra = 0x84,        ///< capsule of 96 measurements
  dense = 0x85,        ///< capsule of 40 measurements
  ultra_dense = 0x86,  ///< capsule of 64 measurements with quality, and a time
  board_flags = 0xFF,  ///< features of the adapter board
};

/// Bytes of a node or capsule; 0 for other responses.
[[nodiscard]] constexpr std::size_t rplidar_packet_bytes(RplidarResponse response) {
  constexpr std::array<std::uint16_t, 6> kBytes = {5, 84, 781, 132, 84, 170};  // from node on
  const auto i =
      static_cast<std::size_t>(response) - static_cast<std::size_t>(RplidarResponse::node);
  return i < kBytes.size() ? kBytes[i] : 0;
}

/// Measurements in a node or capsule; 0 for other responses.
[[nodiscard]] constexpr int rplidar_packet_points(RplidarResponse response) {
  using enum RplidarResponse;
  if (response == node) return 1;
  if (response == express) return 32;
  if (response == dense) return 40;
  if (response == ultra_dense) return 64;
  return response == ultra || response == hq ? 96 : 0;
}

/// The seven bytes in front of a response.
struct RplidarDescriptor {
  static constexpr std::size_t kBytes = 7;           ///< on the line
  RplidarResponse response = RplidarResponse::none;  ///< its type
  std::uint32_t length = 0;                          ///< of each packet
  bool stream = false;  ///< packets follow each other until the next request
};

/// Whether this response exists with this length: seven matching bytes are hardly accidental.
[[nodiscard]] constexpr bool is_known(const RplidarDescriptor& d) {
  struct Known {
    RplidarResponse response;
    bool stream;
    std::uint32_t least, most;  ///< length
  };
  using enum RplidarResponse;
  constexpr std::array<Known, 12> kKnown = {{{info, false, 20, 20},
                                             {health, false, 3, 3},
                                             {sample_rate, false, 4, 4},
                                             {conf, false, 4, 255},
                                             {conf_set, false, 8, 8},
                                             {board_flags, false, 4, 4},
                                             {node, true, 5, 5},
                                             {express, true, 84, 84},
                                             {dense, true, 84, 84},
                                             {ultra, true, 132, 132},
                                             {ultra_dense, true, 170, 170},
                                             {hq, true, 781, 781}}};
  return std::any_of(kKnown.begin(), kKnown.end(), [&](const Known& k) {
    return d.response == k.response && d.stream == k.stream && d.length >= k.least &&
           d.length <= k.most;
  });
}

/// The descriptor `b` begins with: A5 5A, length (30 bits) and mode (2), type.
[[nodiscard]] inline std::optional<RplidarDescriptor> rplidar_descriptor(Bytes b) {
  if (b.size() < RplidarDescriptor::kBytes || b[0] != 0xA5 || b[1] != 0x5A) return std::nullopt;
  const auto word = load_le<std::uint32_t>(&b[2]);
  const RplidarDescriptor d{static_cast<RplidarResponse>(b[6]), word & 0x3FFFFFFFU,
                            word >> 30 == 1};
  return word >> 30 <= 1 && is_known(d) ? std::optional(d) : std::nullopt;
}

/// Response to rplidar_get_info.
struct RplidarInfo {
  std::uint8_t model = 0;  ///< high four bits the series (below 4: A), low four the variant
  std::uint8_t firmware_major = 0,        ///< before the point
      firmware_minor = 0,                 ///< after it
      hardware = 0;                       ///< version
  std::array<std::uint8_t, 16> serial{};  ///< number
};

/// Response to rplidar_get_health.
struct RplidarHealth {
  /// The state.
  enum class Status : std::uint8_t {
    good = 0,     ///< it measures
    warning = 1,  ///< it may fail soon
    error = 2,    ///< it does not measure
  };
  Status status = Status::error;  ///< after an error a reset is required
  std::uint16_t code = 0;         ///< of the error or warning
};

/// Time of one sample.
struct RplidarSampleRate {
  std::uint16_t standard_us = 0,  ///< of a scan of nodes
      express_us = 0;             ///< of a scan of capsules
};

/// The content of a response of 20 bytes.
[[nodiscard]] inline std::optional<RplidarInfo> rplidar_info(Bytes b) {
  if (b.size() != 20) return std::nullopt;
  RplidarInfo info{b[0], b[2], b[1], b[3], {}};
  for (std::size_t i = 0; i < 16; ++i) info.serial[i] = b[4 + i];
  return info;
}

/// The content of a response of 3 bytes.
[[nodiscard]] inline std::optional<RplidarHealth> rplidar_health(Bytes b) {
  if (b.size() != 3 || b[0] > 2) return std::nullopt;
  return RplidarHealth{static_cast<RplidarHealth::Status>(b[0]), load_le<std::uint16_t>(&b[1])};
}

/// The content of a response of 4 bytes.
[[nodiscard]] inline std::optional<RplidarSampleRate> rplidar_sample_rate(Bytes b) {
  if (b.size() != 4) return std::nullopt;
  return RplidarSampleRate{load_le<std::uint16_t>(&b[0]), load_le<std::uint16_t>(&b[2])};
}

}  // namespace wayfare::decode
