#pragma once

// Messages with all that a device sends, beside the measurements in the published schemas: every
// node of an RPLIDAR, a TI radar's profiles, maps, statistics and targets, an Xsens unit's
// orientation, position and status, and where the sensors are mounted.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/decode/mt_raw.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/decode/ti_tracking.hpp>
#include <wayfare/logger/messages.hpp>

namespace wayfare::logger {

/// wayfare.LidarNodes: all points of a revolution, packed as in foxglove.PointCloud with the fields
/// angle (32-bit float, degrees clockwise), distance (u32, 1/4 mm, 0: no return), time (u32, ns
/// after the timestamp), quality (u8) and start (u8, 1: first of a revolution).
[[nodiscard]] MessageSchema lidar_nodes_schema();
/// The message of a revolution; its timestamp is the first point's time, `frame` its frame_id.
[[nodiscard]] std::string lidar_nodes_json(std::span<const decode::TimedRplidarPoint> points,
                                           std::string_view frame);
/// The inverse. Error: text that is no such message.
[[nodiscard]] Result<std::vector<decode::TimedRplidarPoint>> parse_lidar_nodes(
    std::string_view json);

/// All of a TI radar's frame but its points. What the sensor does not send is empty.
struct RadarFrame {
  LogTime time;                                      ///< of the frame
  std::uint32_t number = 0,                          ///< of the frame
      subframe = 0,                                  ///< index
      platform = 0,                                  ///< 0xA1843 …
      version = 0,                                   ///< as in TiHeader
      points = 0;                                    ///< detected
  std::optional<decode::TiStatistics> statistics;    ///< times and loads
  std::optional<decode::TiTemperature> temperature;  ///< of the chip
  std::vector<std::uint16_t> range_profile,          ///< levels, see decode::ti_level_db
      noise_profile,                                 ///< levels
      range_doppler_map;                             ///< levels, range by range
  std::vector<std::int16_t> azimuth_map;             ///< imaginary, real; range by range
  std::vector<std::uint32_t> linear_profile;         ///< of an xWRL sensor
  std::vector<decode::TiTarget> targets;             ///< tracked
  std::vector<std::uint8_t> target_index;            ///< of each point of the frame before
  std::optional<bool> presence;                      ///< of anyone in the zone
};

/// What a frame has.
[[nodiscard]] RadarFrame radar_frame(const decode::TiFrame& frame, LogTime time);
/// wayfare.RadarFrame; the maps are base64 of 16-bit numbers, little endian.
[[nodiscard]] MessageSchema radar_frame_schema();
/// The message; `frame` is its frame_id.
[[nodiscard]] std::string radar_frame_json(const RadarFrame& radar, std::string_view frame);
/// The inverse. Error: text that is no such message.
[[nodiscard]] Result<RadarFrame> parse_radar_frame(std::string_view json);

/// An Xsens unit's message without acceleration, rate and magnetic field, which wayfare.Imu has.
struct MtState {
  LogTime time;                                 ///< of the measurement
  decode::MtSample sample;                      ///< as sent
  std::vector<decode::MtSatellite> satellites;  ///< in view
  decode::MtRawReadings raw;                    ///< uncalibrated

  /// Whether it has more than counters and times.
  [[nodiscard]] bool has_content() const;
};

/// The state in an MTData2 message whose sample is `sample`.
[[nodiscard]] MtState mt_state(decode::Bytes data, const decode::MtSample& sample, LogTime time);
/// wayfare.MtState: the fields of decode::MtSample that the unit sends, under their names.
[[nodiscard]] MessageSchema mt_state_schema();
/// The message; `frame` is its frame_id.
[[nodiscard]] std::string mt_state_json(const MtState& state, std::string_view frame);
/// The inverse. Error: text that is no such message.
[[nodiscard]] Result<MtState> parse_mt_state(std::string_view json);

/// Where a sensor is mounted.
struct Mounting {
  std::string parent = "base_link";  ///< frame it is mounted on
  std::string child;                 ///< frame of the sensor
  SE3d pose;                         ///< of the sensor in the parent's frame
};

/// foxglove.FrameTransforms.
[[nodiscard]] MessageSchema transforms_schema();
/// The message of all mountings.
[[nodiscard]] std::string transforms_json(std::span<const Mounting> mountings, LogTime time);
/// The inverse. Error: text that is no such message.
[[nodiscard]] Result<std::vector<Mounting>> parse_transforms(std::string_view json);
/// The mountings that a recording has on /tf_static; none where it has no such topic. Error: the
/// file cannot be read.
[[nodiscard]] Result<std::vector<Mounting>> read_mountings(const std::string& path);

}  // namespace wayfare::logger
