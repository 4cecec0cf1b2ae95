#pragma once

// The description of a recording for the navigation programs: how foreign files' columns are
// called, how the unit is mounted, how it errs, and the filter's parameters.

#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/columns.hpp>
#include <wayfare/nav/gnss_ins.hpp>

namespace wayfare::examples {

/// Of a file of columns.
struct FileDescription {
  io::ColumnFormat format;
  /// Velocities are stamped this much too late, s: those of many receivers are means over the
  /// interval that ends at their stamp.
  double velocity_late_s = 0.0;
};

struct NavConfig {
  std::string note;  ///< for people
  std::vector<FileDescription>
      imu;  ///< one for each file of the unit; empty: they name their columns
  FileDescription imu_clock, ranges, fixes, truth;
  /// The reference gives the antenna's place, else the unit's.
  bool truth_is_antenna = true;
  /// The reference is another receiver's or phone's solution: differences are not errors.
  bool truth_is_true = true;
  double elevation_mask_deg = 10.0;
  double min_cn0_dbhz = 0.0;
  GnssInsOptions filter;
};

/// From a JSON object; what it does not name keeps its default. Errors name the key: not JSON, an
/// unknown key, a value of the wrong kind or out of range.
[[nodiscard]] Result<NavConfig> read_nav_config(const std::string& path);
[[nodiscard]] Result<NavConfig> parse_nav_config(const std::string& text,
                                                 const std::string& source);

/// Mounting, noise and filter of `config` as such a file; what describes columns is left out.
[[nodiscard]] std::string format_nav_config(const NavConfig& config);

/// Every key with its default, as such a file.
[[nodiscard]] std::string default_nav_config();

}  // namespace wayfare::examples
