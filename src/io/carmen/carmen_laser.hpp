#pragma once

// Private: properties of the laser derived from a whole CARMEN log.

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/io/carmen.hpp>

#include "io/carmen/carmen_lines.hpp"

namespace wayfare::io::carmen {

/// The PARAM lines of a log, as numbers.
class Parameters {
 public:
  explicit Parameters(const std::map<std::string, std::string>& values) : values_(values) {}

  /// nullopt where the name is missing or its value is not a finite number.
  [[nodiscard]] std::optional<double> find(const std::string& name) const;
  /// The same, 0 instead of nullopt.
  [[nodiscard]] double operator[](const char* name) const { return find(name).value_or(0.0); }

 private:
  const std::map<std::string, std::string>& values_;
};

/// Bearings of a scan whose line has none: by the number of beams, or PARAM.
void set_bearings(LaserScan& scan, const Parameters& parameters);

/// Ranges of `scans` from here on mean "no return".
[[nodiscard]] float range_limit(const std::vector<ScanLine>& scans, const Parameters& parameters,
                                const CarmenOptions& options);

/// Mounting of the laser: from PARAM, or from the difference of laser and robot pose if constant.
[[nodiscard]] SE2d mounting(const std::vector<ScanLine>& scans, const Parameters& parameters);

/// Mounting of the radar, from PARAM.
[[nodiscard]] SE2d radar_mounting(const Parameters& parameters);

}  // namespace wayfare::io::carmen
