#pragma once

// Occupied voxels or points as text, one per line, in the format of ColoRadar's maps: "(x y z)" or
// "x,y,z", metres. Brackets, commas and blanks separate the numbers.

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

struct PointText {
  std::vector<Eigen::Vector3d> points_m;
  Problems problems;  ///< skipped lines
};

/// Empty lines and comments (#) are skipped, malformed lines reported by number and skipped.
/// Errors: the file cannot be read or contains no point.
[[nodiscard]] Result<PointText> read_points(const std::string& path);
[[nodiscard]] Result<PointText> parse_points(std::string_view text, const std::string& source);

}  // namespace wayfare::io
