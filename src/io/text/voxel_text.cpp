#include <wayfare/io/voxel_text.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include "io/text/text.hpp"

namespace wayfare::io {
namespace {

bool is_separator(char c) { return c == '(' || c == ')' || c == ',' || c == ';'; }

Result<Eigen::Vector3d> parse_point(std::string line) {
  std::replace_if(line.begin(), line.end(), is_separator, ' ');
  text::Tokens tokens(line);
  Eigen::Vector3d point;
  for (int i = 0; i < 3; ++i)
    if (!tokens.number(point[i]) || !std::isfinite(point[i]))
      return Error{ErrorCode::parse, "expected three finite numbers"};
  if (!tokens.at_end()) return Error{ErrorCode::parse, "more than three numbers"};
  return point;
}

}  // namespace

Result<PointText> parse_points(std::string_view all, const std::string& source) {
  PointText result;
  text::Lines lines(all);
  for (std::string_view line; lines.next(line);) {
    if (line.starts_with('#')) continue;
    if (std::all_of(line.begin(), line.end(), text::is_space)) continue;
    auto point = parse_point(std::string(line.substr(0, 200)));
    if (point) {
      result.points_m.push_back(*point);
    } else {
      result.problems.add({point.error().code, point.error().message, source, lines.number()});
    }
  }
  if (result.points_m.empty()) return Error{ErrorCode::parse, "contains no point", source};
  return result;
}

Result<PointText> read_points(const std::string& path) {
  const Result<FileContent> content = read_file(path);
  if (!content) return content.error();
  auto result = parse_points(content->bytes, path);
  if (result && content->damage) result->problems.add(*content->damage);
  return result;
}

}  // namespace wayfare::io
