#include <wayfare/io/tum.hpp>

#include "io/text/pose_lines.hpp"

namespace wayfare::io {

Result<RelationsFile> parse_relations(std::string_view text, const std::string& source) {
  RelationsFile file;
  const auto take = [&](const auto& times, const auto& v) -> std::string {
    file.relations.push_back({times[0], times[1], SE2d(v[0], v[1], Angle::radians(v[5]))});
    return {};
  };
  if (for_each_pose_line<2, 6>(text, source, file.problems, take) == 0)
    return no_content("relation", source, file.problems);
  return file;
}

Result<RelationsFile> read_relations(const std::string& path, const ReadOptions& options) {
  return read_and_parse<RelationsFile>(path, options, parse_relations);
}

}  // namespace wayfare::io
