#pragma once

// The description of a recording for the navigation programs: columns of foreign files, mounting
// and noise of the unit, parameters of the filter.

#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/columns.hpp>
#include <wayfare/nav/gnss_ins.hpp>

namespace wayfare::examples {

/// Of a text file of columns.
struct FileDescription {
  io::ColumnFormat format;
  /// Delay of the velocities' time stamps, s: those of many receivers are means over the interval
  /// that ends at the stamp.
  double velocity_late_s = 0.0;
};

struct NavConfig {
  std::string note;                  ///< free text
  std::vector<FileDescription> imu;  ///< one per file of the unit; empty: they name their columns
  FileDescription imu_clock, ranges, fixes, truth;
  /// The reference is the antenna's position, else the unit's.
  bool truth_is_antenna = true;
  /// False if the reference is the solution of another receiver or phone: differences are then not
  /// errors.
  bool truth_is_true = true;
  double elevation_mask_deg = 10.0;
  double min_cn0_dbhz = 0.0;
  GnssInsOptions filter;
};

/// From a JSON object; keys that are missing keep their default, as does everything for an empty
/// path. Errors name the key: not JSON, an unknown key, a value of the wrong type or out of range.
[[nodiscard]] Result<NavConfig> read_nav_config(const std::string& path);
[[nodiscard]] Result<NavConfig> parse_nav_config(const std::string& text,
                                                 const std::string& source);

/// Mounting, noise and filter of `config` in the same format, without the columns.
[[nodiscard]] std::string format_nav_config(const NavConfig& config);

/// Every key with its default, in the same format.
[[nodiscard]] std::string default_nav_config();

}  // namespace wayfare::examples
