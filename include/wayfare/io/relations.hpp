#pragma once

// Relations files of the SLAM benchmark of Kümmerle et al. 2009: lines `t1 t2 x y z roll pitch
// yaw`, the true pose at t2 relative to that at t1.

#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/relations.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

struct RelationsFile {
  std::vector<eval::Relation> relations;  ///< z, roll and pitch are ignored
  Problems problems;                      ///< malformed lines, skipped
};

/// Errors: the file cannot be read, or contains no relation.
[[nodiscard]] Result<RelationsFile> read_relations(const std::string& path,
                                                   const ReadOptions& options = {});
[[nodiscard]] Result<RelationsFile> parse_relations(std::string_view text,
                                                    const std::string& source);

}  // namespace wayfare::io
