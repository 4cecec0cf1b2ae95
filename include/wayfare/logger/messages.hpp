#pragma once

// Conversion between measurements and JSON messages with the published foxglove.* schemas, which
// viewers of MCAP recordings support. Foxglove has no message for an inertial unit: wayfare.Imu is
// our own.
//
// Times within ±9e9 s of the epoch are read back.
//
// A logger's recordings as measurements.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare::logger {

/// A message type: its name and the JSON schema of its fields.
struct MessageSchema {
  std::string_view name;  ///< of the type, such as foxglove.LaserScan
  std::string_view json;  ///< JSON schema of the fields
};

/// foxglove.LaserScan, with the additional fields `range_min` and `range_max`; a beam without
/// return is null.
[[nodiscard]] MessageSchema laser_scan_schema();
/// The message of a scan; `frame` is its frame_id. `intensities`: one for each beam, or none.
[[nodiscard]] std::string laser_scan_json(const LaserScan& scan, std::string_view frame,
                                          std::span<const float> intensities = {});
/// The inverse. Error: text that is no such message.
[[nodiscard]] Result<LaserScan> parse_laser_scan(std::string_view json);

/// foxglove.PointCloud with the fields x, y, z, doppler (m/s), snr (dB) and, where the sensor sends
/// it, noise (dB) as 32-bit floats.
[[nodiscard]] MessageSchema point_cloud_schema();
/// The message of a frame of points; `frame` is its frame_id. `noise_db`: one for each point, or
/// none.
[[nodiscard]] std::string point_cloud_json(const RadarScan& scan, std::string_view frame,
                                           std::span<const float> noise_db = {});
/// The inverse. Error: text that is no such message.
[[nodiscard]] Result<RadarScan> parse_point_cloud(std::string_view json);

/// wayfare.Imu: angular_velocity (rad/s), linear_acceleration (specific force, m/s²) and
/// magnetic_field (µT), each null or absent if the unit did not measure it; one at least is there.
[[nodiscard]] MessageSchema imu_schema();
/// The message of a sample; `frame` is its frame_id.
[[nodiscard]] std::string imu_json(const MargSample& sample, std::string_view frame);
/// The inverse. Error: text that is no such message.
[[nodiscard]] Result<MargSample> parse_imu(std::string_view json);

/// Text in the form between the quotes of a JSON string.
[[nodiscard]] std::string json_escaped(std::string_view text);

/// Whether a path has a recording's suffix, `.mcap`.
[[nodiscard]] bool is_recording(const std::string& path);

/// Samples of an inertial unit and where they are from.
struct RecordedMarg {
  MargRecording samples;  ///< in order of time
  std::string topic;      ///< that was read
  io::Problems problems;  ///< faults of the file, and messages that were skipped
};

/// The samples of an inertial unit: messages wayfare.Imu of `topic`, which may be empty if there is
/// only one such channel. Errors: the file cannot be read, the topic is missing, or there are
/// several (which are listed).
[[nodiscard]] Result<RecordedMarg> read_marg_recording(const std::string& path,
                                                       const std::string& topic = {});

/// Scans of a robot and where they are from.
struct RecordedRobot {
  Recording recording;     ///< laser scans and radar frames, each from the first such channel
  std::string scan_topic,  ///< of the laser scans, or empty
      radar_topic;         ///< of the radar frames, or empty
  io::Problems problems;   ///< faults of the file, and messages that were skipped
};

/// The scans of a recording (foxglove.LaserScan, foxglove.PointCloud). Errors: the file cannot be
/// read, or has neither.
[[nodiscard]] Result<RecordedRobot> read_robot_recording(const std::string& path);

}  // namespace wayfare::logger
