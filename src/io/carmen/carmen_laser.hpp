#pragma once

// Private: what a CARMEN log as a whole says of its laser.

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

  /// Nothing where the name is not there or its value is no finite number.
  [[nodiscard]] std::optional<double> find(const std::string& name) const;
  /// The same with a 0 for nothing.
  [[nodiscard]] double operator[](const char* name) const { return find(name).value_or(0.0); }

 private:
  const std::map<std::string, std::string>& values_;
};

/// Bearings of a scan whose line carries none: by the number of beams, and PARAM where that is an
/// unusual one.
void set_bearings(LaserScan& scan, const Parameters& parameters);

/// The range from which on all of `scans` say "no return".
[[nodiscard]] float range_limit(const std::vector<ScanLine>& scans, const Parameters& parameters,
                                const CarmenOptions& options);

/// Where the laser sits: PARAM, or a difference of laser and robot pose that never changes.
[[nodiscard]] SE2d mounting(const std::vector<ScanLine>& scans, const Parameters& parameters);

/// Where PARAM says the radar sits.
[[nodiscard]] SE2d radar_mounting(const Parameters& parameters);

}  // namespace wayfare::io::carmen
