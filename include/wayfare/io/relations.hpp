#pragma once

// Relations files of the SLAM benchmark of Kümmerle et al. 2009: lines `t1 t2 x y z roll pitch
// yaw`, the true pose at t2 seen from t1.

#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/relations.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

struct RelationsFile {
  std::vector<eval::Relation> relations;  ///< z, roll and pitch are left out
  Problems problems;                      ///< malformed lines, skipped
};

/// Errors: the file cannot be read, or holds no relation at all.
[[nodiscard]] Result<RelationsFile> read_relations(const std::string& path,
                                                   const ReadOptions& options = {});
[[nodiscard]] Result<RelationsFile> parse_relations(std::string_view text,
                                                    const std::string& source);

}  // namespace wayfare::io
