#include <wayfare/io/map_image.hpp>

#include <algorithm>
#include <cmath>

#include "io/text/lines.hpp"

namespace wayfare::io {
namespace {

bool is_separator(char c) { return c == '(' || c == ')' || c == ',' || c == ';'; }

bool is_skipped(std::string_view line, const text::Lines&) {
  return line.starts_with('#') || text::trimmed(line).empty();
}

}  // namespace

Result<PointText> parse_points(std::string_view all, const std::string& source) {
  PointText result;
  const auto take = [&](std::string_view whole, const text::Lines&) -> std::string {
    std::string line(whole);
    std::replace_if(line.begin(), line.end(), is_separator, ' ');
    text::Tokens tokens(line);
    Eigen::Vector3d point;
    for (int i = 0; i < 3; ++i)
      if (!tokens.number(point[i]) || !std::isfinite(point[i]))
        return "expected three finite numbers";
    if (!tokens.at_end()) return "more than three numbers";
    result.points_m.push_back(point);
    return {};
  };
  if (for_each_line(all, source, result.problems, is_skipped, take) == 0)
    return Error{ErrorCode::parse, "contains no point", source};
  return result;
}

Result<PointText> read_points(const std::string& path) {
  return read_and_parse(path, {}, parse_points);
}

}  // namespace wayfare::io
