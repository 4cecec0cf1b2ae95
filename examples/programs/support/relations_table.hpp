#pragma once

#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/relations.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::examples {

/// None for an empty path. Reports skipped lines on standard error.
[[nodiscard]] Result<std::vector<eval::Relation>> read_relations_or_none(const std::string& path);

/// Errors of odometry, if the recording has it, and of the system `name`, whose trajectory is
/// interpolated at the relations' times in one row, and taken at the nearest pose in the other.
[[nodiscard]] eval::Table relations_table(const std::string& name, const Recording& recording,
                                          const Trajectory& trajectory,
                                          const std::vector<eval::Relation>& relations);

}  // namespace wayfare::examples
