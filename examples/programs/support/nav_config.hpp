#pragma once

// The description of a recording for the navigation programs: columns of foreign files, mounting
// and noise of the unit, parameters of the filter, and its reading.

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/nav_recording.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/ros/recording.hpp>

namespace wayfare::examples {

/// Files of a recording, also ROS recordings.
struct NavFiles : io::NavFiles {
  ros::TopicNames topics;
};

struct NavConfig : io::NavFormats {
  std::string note;  ///< free text
  /// The reference is the antenna's position, else the unit's.
  bool truth_is_antenna = true;
  /// False if the reference is the solution of another receiver or phone: differences are then not
  /// errors.
  bool truth_is_true = true;
  /// Multiply the unit's readings axis by axis: units and signs of columns that are not as named.
  Eigen::Vector3d gyro_factor = Eigen::Vector3d::Ones(), accel_factor = Eigen::Vector3d::Ones();
  std::optional<GnssInsStart> start;   ///< initial state
  std::optional<double> start_time_s;  ///< absent: the unit's first sample
  GnssInsOptions filter;
};

/// A satellite outage as given on a command line.
struct NavOutage {
  double start_s = 0.0;  ///< since the unit's first sample
  double length_s = 0.0;
  std::size_t satellites_left = 0;
};

/// "START:LENGTH[:SATELLITES],..." in seconds.
[[nodiscard]] Result<std::vector<NavOutage>> parse_outages(const std::string& text);
/// A wrong argument if one of them begins after a recording of this length.
[[nodiscard]] Result<void> check_outages(const std::vector<NavOutage>& outages, double length_s);

/// io::read_nav_recording, with the description's factors and start; reports skipped lines on
/// standard error. `apart`: streams that do not overlap in time are no error.
[[nodiscard]] Result<io::NavRecording> load_nav_recording(
    const NavFiles& files, const NavConfig& config,
    const std::function<void(double)>& progress = {}, bool apart = false);

/// From a JSON object; keys that are missing keep their default, as does everything for an empty
/// path. Errors name the key: not JSON, an unknown key, a value of the wrong type or out of range.
[[nodiscard]] Result<NavConfig> read_nav_config(const std::string& path);
[[nodiscard]] Result<NavConfig> parse_nav_config(const std::string& text,
                                                 const std::string& source);

/// Adds columns "FILE:NAME=COLUMN" of the command line, such as "imu:gx_degps=Gyro X".
[[nodiscard]] Result<void> choose_columns(const std::vector<std::string>& texts, NavConfig& config);

/// Sets options "NAME=VALUE" of the filter, such as "correlated_share=0.8".
[[nodiscard]] Result<void> set_filter_options(const std::vector<std::string>& texts,
                                              NavConfig& config);

/// Mounting, noise and filter of `config` in the same format, without the columns.
[[nodiscard]] std::string format_nav_config(const NavConfig& config);

/// The description at `path` with mounting, lever arm, time offset and factors of `config`.
[[nodiscard]] Result<std::string> updated_nav_config(const std::string& path,
                                                     const NavConfig& config);

/// Every key with its default, in the same format.
[[nodiscard]] std::string default_nav_config();

}  // namespace wayfare::examples
