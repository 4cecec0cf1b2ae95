#pragma once

// Occupied voxels and places as text, one point a line, as ColoRadar's maps are published:
// "(x y z)" or "x,y,z", metres. Brackets, commas and blanks part the numbers.

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

struct PointText {
  std::vector<Eigen::Vector3d> points_m;
  Problems problems;  ///< lines that were left out
};

/// Empty lines and comments (#) are skipped, malformed lines reported by number and left out. Fails
/// where the file cannot be read or holds no point.
[[nodiscard]] Result<PointText> read_points(const std::string& path);
[[nodiscard]] Result<PointText> parse_points(std::string_view text, const std::string& source);

}  // namespace wayfare::io
